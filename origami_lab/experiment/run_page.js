// The page of one run.

const SILENT = 30000; // milliseconds without a word after which a run may have been ended
const MOST_SHAPES = 60;
let now = null;
const pieces = [];
let drawn = "";

function live(data) {
  now = data;
}

function ended(place, entries) {
  pieces[place] = entries;
}

const decimals = { return_percent: 1, return_mm: 2, driving_angle: 1, likeness: 2, seconds: 1 };
const whole = ["interactions_to_best", "interactions", "vertices", "panels"];
const shown = (name, value) => number(["return_percent", "return_mm"].includes(name) && value !== undefined ? -value : value, whole.includes(name) ? 0 : (decimals[name] ?? 4));

function verdict(entry) {
  if (!entry.certificate) return "–";
  const kind = { certified: "certified", refuted: "refuted" }[entry.certificate] ?? null;
  const said = entry.files.includes("certificate.json") ? link(address(`seed=${entry.seed}`, "certificate.json"), entry.certificate) : entry.certificate;
  return el("span", { class: kind }, said);
}

function stateWords() {
  const running = now.state === "running";
  const silent = running && Date.now() - now.at > SILENT;
  const done = `${number(now.ended, 0)} of ${many(now.seeds, "trial")}`;
  if (silent) return `${done} ended. No word for ${ago(Date.now() - now.at)}: it may have been killed; the command below goes on.`;
  const said = running ? `running: ${done} ended` : now.state === "finished" ? `finished: ${many(now.ended, "trial")}` : `${now.state}: ${done} ended`;
  const others = Object.entries(now.outcomes).filter(([name]) => name !== "ok").map(([name, count]) => `${count} ${name}`);
  const mean = now.returns ? `mean return ${spread(now.returns)}` : "";
  const verdicts = Object.entries(now.verdicts).map(([name, count]) => `${count} ${name}`).join(", ");
  return [said, ...others, mean, verdicts].filter(Boolean).join(" · ");
}

function showRunning() {
  put("running", ...(now.state === "running" ? now.running : []).map((trial) =>
    el("div", { class: "going" },
      el("b", {}, `seed ${trial.seed}`),
      el("progress", { max: now.budget, value: Math.min(trial.interactions, now.budget), "aria-label": `seed ${trial.seed}` }),
      el("span", {}, `${number(trial.interactions, 0)} of ${number(now.budget, 0)}`),
      el("span", {}, trial.best === null ? "no design yet" : `best ${number(trial.best, 4)}`),
      el("span", { class: "quiet" }, trial.doing === "searching" && trial.interactions >= now.budget ? "writing its files" : trial.doing),
    )));
}

function showBest(best) {
  if (!best) return put("best");
  const folder = `seed=${best.seed}`;
  const same = Object.keys(best.cells).find((name) => name.startsWith("return_") && best.cells[name] === best.cells.return);
  const cells = Object.entries(best.cells).filter(([name]) => known.columns[name] && name !== same);
  const fact = (name, value) => el("div", {}, el("dt", {}, name), el("dd", {}, value));
  const facts = [fact("seed", String(best.seed)), fact("certificate", verdict(best)), ...cells.map(([name, value]) => fact(known.columns[name], shown(name, value)))];
  const files = best.files.map((name) => el("li", {}, link(address(folder, name), known.files[name])));
  const viewer = ["polished.html", "best.html"].find((name) => best.files.includes(name));
  const pictures = [picture("", best, `the best design, folded: seed ${best.seed}`)];
  if (best.files.includes("pattern.png")) pictures.push(el("div", { class: "card" }, el("img", { src: address(folder, "pattern.png"), alt: "its crease pattern" })));
  const turn = viewer ? el("button", { type: "button" }, "Turn and fold it here") : null;
  const place = el("div", {});
  turn?.addEventListener("click", () => {
    place.replaceChildren(el("iframe", { src: address(folder, viewer), title: "the best design, to turn and fold" }));
    turn.remove();
  });
  put("best",
    el("div", { class: "two" }, ...pictures),
    el("dl", { class: "tiles" }, ...facts),
    el("div", { class: "turn" }, turn, el("ul", { class: "links" }, ...files)),
    place);
}

function showSeeds(entries, best) {
  const every = entries.length > 1 ? [...entries] : [];
  const chosen = every.length > MOST_SHAPES && !byId("seeds").dataset.all
    ? [...every].sort((a, b) => (b.cells.return ?? -Infinity) - (a.cells.return ?? -Infinity)).slice(0, MOST_SHAPES) : every;
  const shapes = chosen.sort((a, b) => a.seed - b.seed).map((entry) => {
    const caption = el("figcaption", {}, el("b", {}, `seed ${entry.seed}`), entry.cells.return === undefined ? entry.status : number(entry.cells.return, 4), " ", entry.certificate ? verdict(entry) : "");
    const shape = picture("", entry, `seed ${entry.seed}, folded`);
    const leads = entry.files.includes("best.html") ? link(address(`seed=${entry.seed}`, "best.html"), shape, { title: "turn and fold it" }) : shape;
    return el("figure", { class: entry.seed === best?.seed ? "first" : null }, leads, caption);
  });
  const more = chosen.length < every.length ? el("button", { type: "button" }, `show all ${every.length}`) : null;
  more?.addEventListener("click", () => {
    byId("seeds").dataset.all = "yes";
    showSeeds(entries, best);
  });
  put("seeds", shapes.length ? el("div", { class: "shapes" }, ...shapes) : null, more);
}

function showTable(entries, best) {
  const names = Object.keys(known.columns).filter((name) => entries.some((entry) => entry.cells[name] !== undefined));
  const same = names.filter((name) => name.startsWith("return_") && entries.every(({ cells }) => cells[name] === cells.return));
  const kept = names.filter((name) => name !== same[0]);
  const columns = [{ title: "seed" }, ...kept.map((name) => ({ title: known.columns[name], number: true })), { title: "certificate" }];
  const odd = entries.some(({ status }) => status !== "ok");
  if (odd) columns.push({ title: "status" });
  const rows = [...entries].sort((a, b) => a.seed - b.seed).map((entry) => ({
    best: entry.seed === best?.seed,
    cells: [String(entry.seed), ...kept.map((name) => shown(name, entry.cells[name])), verdict(entry), ...(odd ? [[entry.status, entry.reason].filter(Boolean).join(": ")] : [])],
  }));
  put("table", rows.length ? tableOf(columns, rows, "trials") : null);
}

function showCurves(entries, best) {
  const series = entries.map(({ seed, curve }) => ({ points: curve, label: `seed ${seed}`, best: seed === best?.seed }));
  const running = now.running.map(({ seed, curve }) => ({ points: curve, label: `seed ${seed}, running`, best: false }));
  put("curves", stepChart([...series, ...running], now.budget, "best return so far over interactions, one line a seed"));
}

async function refresh() {
  const before = now?.ended ?? -1;
  const heard = await load("index.data/live.js");
  if (now && now.ended !== before) {
    const first = before < now.ended && before >= 0 ? Math.floor(before / now.piece) : 0;
    for (let k = first; k < Math.ceil(now.ended / now.piece); k += 1) await load(`index.data/ended-${k}.js`);
  }
  if (now) {
    const entries = pieces.slice(0, Math.ceil(now.ended / now.piece)).flat();
    byId("state").textContent = stateWords();
    showRunning();
    const key = JSON.stringify([now.ended, now.best?.seed, now.best?.files]);
    if (key !== drawn) {
      drawn = key;
      showBest(now.best);
      showSeeds(entries, now.best);
      showTable(entries, now.best);
      put("files", ...now.files.map((name) => el("li", {}, link(address(name), name))));
    }
    showCurves(entries, now.best);
    const over = now.state === "finished";
    byId("go-on").hidden = over;
    byId("longer").hidden = !over;
  } else if (!heard) {
    byId("state").textContent = "The data of this page, index.data/live.js beside it, cannot be read.";
  }
  if (!now || now.state === "running") setTimeout(refresh, 2000);
}

refresh();
