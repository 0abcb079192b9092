// The page of a sweep.

let now = null;
const pieces = [];

function live(data) {
  now = data;
}

function ended(place, entries) {
  pieces[place] = entries;
}

const short = (value) => (/^-?\d*\.\d{5,}$/.test(value) ? String(Number(Number(value).toPrecision(4))) : value);

function showBest(best) {
  if (!best) return put("best");
  const tile = (name, value) => el("div", {}, el("dt", {}, name), el("dd", {}, value));
  const point = Object.entries(best.point).map(([name, value]) => tile(name, short(value)));
  put("best",
    el("dl", { class: "tiles" }, tile("trial", link(address("trials", String(best.trial).padStart(4, "0"), "index.html"), String(best.trial))), tile("mean return", spread(best.returns)), ...point),
    now.command ? el("pre", {}, now.command) : null);
}

function showHeldOut({ seeds, budget, settings }) {
  const names = Object.keys(settings);
  const columns = [{ title: "settings" }, { title: "return", number: true }, { title: "the best is better by", number: true }, { title: "95 % interval", number: true }, { title: "p", number: true }, { title: "verdict" }];
  const rows = names.map((name) => {
    const { returns, difference } = settings[name];
    const digits = spread({ ...returns, std: returns.std ?? 0 }).split(" ")[0].split(".")[1]?.length ?? 0;
    const more = difference ? [number(difference.mean, digits), `${number(difference.low, digits)} to ${number(difference.high, digits)}`, number(difference.p, 3), difference.verdict] : ["", "", "", ""];
    return { best: name === "best", cells: [name, spread(returns), ...more] };
  });
  put("held-out", names.length ? tableOf(columns, rows, "comparison on held-out seeds") : null,
    names.length ? el("p", { class: "quiet" }, `Seeds ${seeds}, ${number(budget, 0)} interactions each.`) : null);
}

function showHistory(entries) {
  const points = [];
  for (const { trial, state, returns } of [...entries].sort((a, b) => a.trial - b.trial)) {
    if (state !== "complete" || !returns) continue;
    const before = points.at(-1)?.[1] ?? -Infinity;
    points.push([trial + 1, Math.max(before, returns.mean)]);
  }
  put("history", points.length > 1 && !now.figures.includes("history") ? stepChart([{ points, label: "best so far", best: true }], null, "best mean return so far over trials") : null);
}

function showTable(entries) {
  const odd = entries.some(({ reason }) => reason);
  const columns = [{ title: "trial" }, { title: "mean return", number: true }, { title: "state" }, ...known.space.map((title) => ({ title, number: true })), { title: "seconds", number: true }, ...(odd ? [{ title: "reason" }] : [])];
  const rows = [...entries].sort((a, b) => a.trial - b.trial).map(({ trial, returns, state, point, seconds, reason }) => ({
    best: trial === now.best?.trial,
    cells: [link(address("trials", String(trial).padStart(4, "0"), "index.html"), String(trial)), returns ? spread(returns) : "–", state, ...known.space.map((name) => short(point[name] ?? "")), number(seconds, 0), ...(odd ? [reason] : [])],
  }));
  put("table", rows.length ? tableOf(columns, rows, "trials") : null);
}

async function refresh() {
  const before = now?.ended ?? -1;
  const heard = await load("index.data/live.js");
  if (now && now.ended !== before) {
    const first = before >= 0 && before < now.ended ? Math.floor(before / now.piece) : 0;
    for (let k = first; k < Math.ceil(now.ended / now.piece); k += 1) await load(`index.data/ended-${k}.js`);
  }
  if (now) {
    const entries = [...new Map(pieces.slice(0, Math.ceil(now.ended / now.piece)).flat().map((entry) => [entry.trial, entry])).values()];
    const silent = now.state === "running" && Date.now() - now.at > 30000;
    const words = [`${now.state}: ${number(entries.length, 0)} of ${many(now.trials, "trial")} ended`];
    if (now.running && now.state === "running") words.push(`${now.running} running`);
    if (silent) words.push(`no word for ${ago(Date.now() - now.at)}: it may have been killed`);
    byId("state").textContent = words.join(" · ");
    showBest(now.best);
    showHeldOut(now.held_out);
    showHistory(entries);
    showTable(entries);
    put("figures", ...now.figures.map((name) => el("img", { src: `${name}.png`, alt: name.replace("_", " "), loading: "lazy" })));
    put("files", ...now.files.map((name) => el("li", {}, link(address(name), name))));
  } else if (!heard) {
    byId("state").textContent = "The data of this page, index.data/live.js beside it, cannot be read.";
  }
  if (!now || now.state === "running") setTimeout(refresh, 2000);
}

refresh();
