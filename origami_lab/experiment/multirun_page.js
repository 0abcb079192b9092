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

async function refresh() {
  for (place = 0; place < known.jobs.length; place += 1) {
    if (found[place]?.state !== "finished") await load(address(known.jobs[place].folder, known.data));
  }
  showJobs();
  const count = (state) => found.filter((said) => said?.state === state).length;
  const words = [`${count("finished")} of ${many(known.jobs.length, "job")} finished`];
  if (count("running")) words.push(`${count("running")} running`);
  const trials = found.reduce((sum, said) => sum + (said?.ended ?? 0), 0);
  byId("state").textContent = [...words, many(trials, "trial")].join(" · ");
  if (count("finished") < known.jobs.length) setTimeout(refresh, 3000);
}

refresh();
