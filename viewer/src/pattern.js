// The flat crease pattern, as SVG.

const NAMES = { M: "mountain", V: "valley", F: "flat", J: "flat", U: "unassigned", B: "boundary", C: "cut" };

function element(name, attributes, parent) {
  const made = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  parent.append(made);
  return made;
}

export class Pattern {
  constructor(host, data, onPick) {
    const { vertices, edges, panels } = data;
    const xs = vertices.map((v) => v[0]);
    const ys = vertices.map((v) => -v[1]); // y runs down in SVG
    const [left, top] = [Math.min(...xs), Math.min(...ys)];
    const [width, height] = [Math.max(...xs) - left, Math.max(...ys) - top];
    const size = Math.max(width, height);
    const margin = 0.05 * size;
    const box = [left - margin, top - margin, width + 2 * margin, height + 2 * margin];
    const svg = element("svg", { viewBox: box.join(" "), role: "img", "aria-label": "crease pattern" }, host);
    this.marks = { panel: [], edge: [], vertex: [] };
    const mark = (kind, index, shape, target = shape) => {
      this.marks[kind][index] = shape;
      target.dataset.kind = kind;
      target.dataset.index = index;
    };
    panels.forEach((panel, k) => {
      const points = panel.map((v) => `${xs[v]},${ys[v]}`).join(" ");
      mark("panel", k, element("polygon", { points, class: "panel" }, svg));
    });
    const ends = ([u, v]) => ({ x1: xs[u], y1: ys[u], x2: xs[v], y2: ys[v] });
    const hits = [];
    this.creases = edges.map((edge, k) => {
      const line = element("line", { ...ends(edge), class: "crease" }, svg);
      hits.push(["line", { ...ends(edge), class: "hit", "stroke-width": 0.025 * size }, "edge", k, line]);
      return line;
    });
    vertices.forEach((_, k) => {
      const mode = data.modes ? ["minus", "leaf", "plus"][data.modes[k] + 1] : "leaf";
      const place = { cx: xs[k], cy: ys[k] };
      const dot = element("circle", { ...place, r: (mode === "leaf" ? 0.006 : 0.0095) * size, class: mode }, svg);
      hits.push(["circle", { ...place, r: 0.022 * size, class: "hit" }, "vertex", k, dot]);
    });
    for (const [name, attributes, kind, k, shape] of hits) mark(kind, k, shape, element(name, attributes, svg));
    this.driven = data.driven;
    const pick = (event) => {
      const { kind, index } = event.target.dataset;
      onPick(kind ? { kind, index: Number(index) } : null);
    };
    svg.addEventListener("pointermove", pick);
    svg.addEventListener("pointerdown", pick);
    svg.addEventListener("pointerleave", (event) => event.pointerType === "mouse" && onPick(null));
  }

  show(motion, state) {
    this.creases.forEach((line, k) => {
      const driven = this.driven && this.driven[k] ? " driven" : "";
      line.setAttribute("class", `crease ${NAMES[motion.letter(state, k)]}${driven}`);
    });
    this.marked?.classList.add("picked");
  }

  highlight(picked) {
    if (this.marked) this.marked.classList.remove("picked");
    this.marked = picked && this.marks[picked.kind][picked.index];
    if (this.marked) this.marked.classList.add("picked");
  }
}

export { NAMES };
