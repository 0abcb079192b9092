"use strict";
// What the pages of runs, multiruns and sweeps share. Nothing here makes HTML of a text: all is put in as text.

const SVG = "http://www.w3.org/2000/svg";
const byId = (id) => document.getElementById(id);
const known = JSON.parse(byId("page").textContent);

function fill(element, attributes, children) {
  for (const [name, value] of Object.entries(attributes)) {
    if (value !== null && value !== false) element.setAttribute(name, value === true ? "" : value);
  }
  element.append(...children.filter((child) => child !== null));
  return element;
}

const el = (name, attributes = {}, ...children) => fill(document.createElement(name), attributes, children);
const draw = (name, attributes = {}, ...children) => fill(document.createElementNS(SVG, name), attributes, children);

function number(value, digits) {
  if (value === null || value === undefined) return "–";
  const text = value.toLocaleString("en", { minimumFractionDigits: digits, maximumFractionDigits: digits });
  return (/[1-9]/.test(text) ? text : text.replace("-", "")).replace("-", "−");
}

// Mean ± std to the first digit of the standard error of the mean.
function spread({ mean, std, n }) {
  const digits = std ? Math.min(Math.max(-Math.floor(Math.log10(std / Math.sqrt(n))), 0), 4) : 4;
  return number(mean, digits) + (std === null ? "" : ` ± ${number(std, digits)}`);
}

const address = (...parts) => parts.map((part) => part.split("/").map(encodeURIComponent).join("/")).join("/");
const link = (where, words, attributes = {}) => el("a", { href: where, ...attributes }, words);
const many = (count, word) => `${number(count, 0)} ${word}${count === 1 ? "" : "s"}`;

function ago(milliseconds) {
  const seconds = milliseconds / 1000;
  return seconds < 90 ? `${Math.round(seconds)} s` : seconds < 5400 ? `${Math.round(seconds / 60)} min` : `${Math.round(seconds / 3600)} h`;
}

// A page from disk may not fetch data, but it may load a script that hands it over.
function load(where) {
  return new Promise((resolve) => {
    const script = el("script", { src: `${where}?${Date.now()}` });
    script.onload = () => resolve(true);
    script.onerror = () => resolve(false);
    document.head.append(script);
  }).finally(() => document.head.lastElementChild.remove());
}

function patternDrawing({ points, edges, letters }, name) {
  const [xs, ys] = [0, 1].map((axis) => points.map((point) => point[axis]));
  const [left, top] = [Math.min(...xs), -Math.max(...ys)];
  const [wide, high] = [Math.max(...xs) - left, -Math.min(...ys) - top];
  const margin = 0.04 * Math.max(wide, high, 1);
  const kinds = { M: "mountain", V: "valley", B: "boundary" };
  const lines = edges.map(([u, v], k) =>
    draw("line", { x1: points[u][0], y1: -points[u][1], x2: points[v][0], y2: -points[v][1], class: `crease ${kinds[letters[k]] ?? ""}` }),
  );
  const box = [left - margin, top - margin, wide + 2 * margin, high + 2 * margin].join(" ");
  return draw("svg", { viewBox: box, class: "pattern", role: "img", "aria-label": name }, ...lines);
}

// Steps of the best return so far over interactions, on a logarithmic axis; the first ones may leave at the bottom.
function stepChart(series, end, name) {
  const shown = series.filter(({ points }) => points.length);
  if (!shown.length) return null;
  const [width, height, left, bottom] = [720, 300, 62, 34];
  const first = Math.max(1, Math.min(...shown.map(({ points }) => points[0][0])));
  const last = Math.max(end ?? 1, first * 1.01, ...shown.map(({ points }) => points.at(-1)[0]));
  const improved = Math.max(...shown.map(({ points }) => points.at(-1)[0]));
  const values = shown.flatMap(({ points }) => points.filter(([at], k) => at >= 0.02 * improved || k === points.length - 1).map((point) => point[1]));
  let [low, high] = [Math.min(...values), Math.max(...values)];
  const room = high - low > 1e-6 ? 0.06 * (high - low) : 0.06; // less than that is rounding
  [low, high] = [low - room, high + room];
  const x = (at) => left + ((width - left - 12) * Math.log(Math.max(at, first) / first)) / Math.log(last / first);
  const y = (value) => Math.min(10 + ((height - bottom - 10) * (high - value)) / (high - low), height - bottom);
  const parts = [];
  const step = 10 ** Math.floor(Math.log10((high - low) / 3));
  const tick = [1, 2, 5, 10].map((k) => k * step).find((size) => (high - low) / size <= 5) ?? step;
  const digits = Math.max(0, -Math.floor(Math.log10(tick)));
  for (let value = Math.ceil(low / tick) * tick; value <= high; value += tick) {
    parts.push(draw("line", { x1: left, x2: width - 12, y1: y(value), y2: y(value), class: "grid" }));
    parts.push(draw("text", { x: left - 8, y: y(value) + 4, "text-anchor": "end" }, number(value, digits)));
  }
  for (let power = Math.ceil(Math.log10(first)); 10 ** power <= last; power += 1) {
    parts.push(draw("line", { x1: x(10 ** power), x2: x(10 ** power), y1: 10, y2: height - bottom, class: "grid" }));
    parts.push(draw("text", { x: x(10 ** power), y: height - bottom + 18, "text-anchor": "middle" }, number(10 ** power, 0)));
  }
  for (const { points, label, best, colour } of [...shown].sort((a, b) => Number(a.best) - Number(b.best))) {
    let path = `M${x(points[0][0]).toFixed(1)} ${y(points[0][1]).toFixed(1)}`;
    for (const [at, value] of points.slice(1)) path += `H${x(at).toFixed(1)}V${y(value).toFixed(1)}`;
    parts.push(draw("path", { d: path, class: ["curve", best && "best", colour].filter(Boolean).join(" ") }, draw("title", {}, label)));
  }
  return draw("svg", { viewBox: `0 0 ${width} ${height}`, class: "chart", role: "img", "aria-label": name }, ...parts);
}

// Cells of a table; the first one heads its row.
function tableOf(columns, rows, name) {
  const head = columns.map(({ title, number: right }) => el("th", { scope: "col", class: right ? "number" : null }, title));
  const body = rows.map(({ cells, best }) =>
    el("tr", { class: best ? "best" : null }, ...cells.map((cell, k) => (k ? el("td", { class: columns[k].number ? "number" : null }, cell) : el("th", { scope: "row" }, cell)))),
  );
  const table = el("table", { "aria-label": name }, el("thead", {}, el("tr", {}, ...head)), el("tbody", {}, ...body));
  return el("div", { class: "wide", tabindex: 0, role: "region", "aria-label": name }, table);
}

function put(id, ...children) {
  const found = children.filter((child) => child !== null);
  byId(id).replaceChildren(...found);
  const section = byId(id).closest("section");
  if (section) section.hidden = !found.length;
}

// The picture of a trial's best design, or a drawing of its pattern; folder leads to that of its run.
function picture(folder, entry, name) {
  const trial = `${folder}seed=${entry.seed}`;
  const file = ["polished.png", "folded.png"].find((one) => entry.files.includes(one));
  if (file) return el("div", { class: "card" }, el("img", { src: address(trial, file), alt: name, loading: "lazy" }));
  if (entry.pattern) return el("div", { class: "card drawn" }, patternDrawing(entry.pattern, name));
  return el("div", { class: "card none" }, entry.status === "ok" ? "no picture" : entry.status);
}
