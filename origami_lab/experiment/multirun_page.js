// The page of a multirun: what each job's own page says of it.

const found = known.jobs.map(() => null);
let place = 0;

function live(data) {
  found[place] = data;
}

function showJobs() {
  const best = {};
  known.jobs.forEach(({ task }, k) => {
    const mean = found[k]?.returns?.mean;
    if (mean !== undefined) best[task] = Math.max(best[task] ?? -Infinity, mean);
  });
  const framed = {};
  known.jobs.forEach(({ task }, k) => {
    const value = found[k]?.best?.cells.return;
    if (value !== undefined) framed[task] = Math.max(framed[task] ?? -Infinity, value);
  });
  const columns = [{ title: "job" }, { title: "return", number: true }, { title: "best", number: true }, { title: "trials", number: true }, { title: "certificates" }, { title: "state" }];
  const rows = known.jobs.map(({ folder, name, task }, k) => {
    const said = found[k];
    const label = said ? link(address(folder, "index.html"), name) : name;
    if (!said) return { best: false, cells: [label, "–", "–", "–", "", "not begun"] };
    const verdicts = Object.entries(said.verdicts).map(([verdict, count]) => `${count} ${verdict}`).join(", ");
    const cells = [label, said.returns ? spread(said.returns) : "–", number(said.best?.cells.return, 4), `${said.ended} of ${said.seeds}`, verdicts, said.state];
    return { best: said.returns?.mean === best[task] && known.jobs.length > 1, cells };
  });
  put("table", tableOf(columns, rows, "jobs"));
  put("shapes", ...known.jobs.flatMap(({ folder, name, task }, k) => {
    const entry = found[k]?.best;
    if (!entry) return [];
    const value = entry.cells.return;
    const figure = el("figure", { class: value === framed[task] ? "first" : null },
      link(address(folder, "index.html"), picture(`${folder}/`, entry, `${name}: the best design`)),
      el("figcaption", {}, el("b", {}, name), `${number(value, 4)}, seed ${entry.seed}`));
    return [figure];
  }));
}

const COLOURS = 8; // those of .curve.k0 and so on

function showCurves() {
  const tasks = [...new Set(known.jobs.map(({ task }) => task))];
  put("curves", ...tasks.map((task) => {
    const series = known.jobs.flatMap((job, k) => job.task === task && found[k]?.curve?.length
      ? [{ points: found[k].curve, label: job.name, mean: found[k].returns?.mean }] : []);
    const drawn = series.sort((a, b) => (b.mean ?? -Infinity) - (a.mean ?? -Infinity)).slice(0, COLOURS)
      .map((one, k) => ({ ...one, colour: `k${k}` }));
    if (!drawn.length) return null;
    const name = `${task}: mean best return so far over interactions`;
    const keys = drawn.map(({ label, colour }) => el("li", {}, draw("svg", { viewBox: "0 0 24 8", class: "key", "aria-hidden": "true" }, draw("path", { d: "M0 4H24", class: `curve ${colour}` })), label));
    const left = series.length - drawn.length;
    if (left) keys.push(el("li", { class: "quiet" }, `and ${many(left, "job")} with less`));
    return el("figure", {}, el("figcaption", {}, el("b", {}, task)), stepChart(drawn, null, name), el("ul", { class: "links" }, ...keys));
  }));
}

async function refresh() {
  for (place = 0; place < known.jobs.length; place += 1) {
    if (found[place]?.state !== "finished") await load(address(known.jobs[place].folder, known.data));
  }
  showJobs();
  showCurves();
  const count = (state) => found.filter((said) => said?.state === state).length;
  const words = [`${count("finished")} of ${many(known.jobs.length, "job")} finished`];
  if (count("running")) words.push(`${count("running")} running`);
  const trials = found.reduce((sum, said) => sum + (said?.ended ?? 0), 0);
  byId("state").textContent = [...words, many(trials, "trial")].join(" · ");
  if (count("finished") < known.jobs.length) setTimeout(refresh, 3000);
}

refresh();
