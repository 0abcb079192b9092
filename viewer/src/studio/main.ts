// The studio's page: what is shown and asked for in turn. Every rule is the server's.

import { get, number, type SheetData } from "../data";
import { Board, type Point, type Tool } from "./board";
import { Connection } from "./connection";
import { Folding } from "./folding";
import type { Ghost, Reply, Request, TellBoard, TellMeasured, TellOpened, TellPointed, TellWelcome, Worth } from "./messages";
import { Partners } from "./partners";

const NEXT: Record<TellBoard["phase"], string> = {
  start: "lay the start pattern: choose an outline or a lit place",
  leaf: "choose a ringed leaf",
  first: "place the first outer crease",
  second: "place the second outer crease",
  third: "place the middle crease",
};

let game: TellOpened | null = null;
let state: TellBoard | null = null;
let board: Board | null = null;
let sheet: SheetData | null = null;
let pinned: { sheet: SheetData; worth: Worth | null } | null = null;
let sign: -1 | 1 = -1;
let moving: Point | null = null;
let told = 0; // answers to what was done

const folding = new Folding(
  (motion, at) => board?.fold(motion, at),
  (panels) => board?.meeting(panels),
);
const connection = new Connection(take, (why) => {
  get("over").hidden = false;
  get("over").querySelector("p")!.textContent =
    why || "The studio has ended. What was saved can be opened again: origami-lab studio FOLDER.";
});
const ask = (request: Request) => connection.ask(request);
const partners = new Partners(
  ask,
  () => [...(board?.region ?? [])].map((key) => key.split(",").map(Number) as Point),
  (proposal) => {
    board?.ghost(proposal?.creases ?? []);
    if (!proposal) showBeside();
  },
);

// --- what is told ---

function take(reply: Reply): void {
  answer(reply);
  if (reply.kind === "board" || reply.kind === "refused") told += 1;
}

function answer(reply: Reply): void {
  switch (reply.kind) {
    case "welcome":
      return welcome(reply);
    case "opening":
      get("opening").textContent = reply.says;
      return;
    case "opened":
      return open(reply);
    case "board":
      return show(reply);
    case "pointed":
      if (connection.isLast(reply.id)) pointed(reply);
      return;
    case "motion":
      if (reply.revision === state?.revision) folding.ends(reply);
      return;
    case "partner":
      partners.told(reply);
      return;
    case "proposals":
      partners.proposed(reply);
      return;
    case "look":
      if (reply.number !== partners.looked) return;
      folding.besideBest = reply.worth?.angle ?? null;
      folding.lay(reply.sheet);
      get("besideTitle").textContent = partners.title(reply);
      get("besideActions").hidden = false;
      return;
    case "measured": {
      if (reply.revision !== state?.revision) return;
      const marks = [reply.sheet, reply.target].filter((mark) => mark !== null);
      folding.pins(marks.map((mark) => mark.at));
      board?.marks(marks.flatMap((mark) => (mark.board ? board!.images(mark.board as Point) : [])));
      get("figures").textContent = figures(reply);
      return;
    }
    case "certified":
      if (reply.revision !== state?.revision) return say("");
      folding.refute(reply.panels);
      say(`${reply.verdict}: ${reply.says}`, reply.verdict === "refuted");
      return;
    case "saved":
      say([`saved in ${reply.path}; open it again: ${reply.command}`, ...reply.notes].join(" · "));
      return;
    case "exported":
      return download(reply.name, reply.content);
    case "refused":
      get("opening").textContent = reply.says;
      say(reply.says, true);
  }
}

function welcome(told: TellWelcome): void {
  get("starts").replaceChildren(...told.starts.map((name) => new Option(name, name)));
  get("tasks").replaceChildren(
    ...told.tasks.map((task) => {
      const card = document.createElement("button");
      card.type = "button";
      card.dataset.open = task.name;
      card.append(Object.assign(document.createElement("b"), { textContent: task.name }));
      card.append(Object.assign(document.createElement("span"), { textContent: task.says }));
      card.addEventListener("click", () => {
        get("opening").textContent = `opening ${task.name} …`;
        ask({ kind: "open", task: task.name, start: get<HTMLSelectElement>("starts").value });
      });
      return card;
    }),
  );
  get("begin").hidden = told.opens;
  get("opening").textContent = told.opens ? "opening …" : "";
}

function open(told: TellOpened): void {
  game = told;
  state = sheet = pinned = moving = null;
  get("gallery").hidden = true;
  get("studio").hidden = false;
  get("title").textContent = told.title;
  document.title = `${told.title} – origami-lab studio`;
  get("title").title = told.rules.join(", ");
  get("format").replaceChildren(...told.formats.map((name) => new Option(name, name)));
  get("figures").textContent = "";
  get("compare").setAttribute("aria-pressed", "false");
  board = new Board(get("board"), told, point, choose);
  board.onDrag = (at, to) => ask({ kind: "shift", at, to });
  folding.open(told.target, told.angles[told.angles.length - 1]);
  partners.open(told);
  partners.looked = null;
  folding.lay(null);
  use("play");
  say(told.rules.join(" · "));
}

function show(told: TellBoard): void {
  const changed = told.revision !== state?.revision || state === null;
  const isFirst = state === null;
  if (told.phase !== state?.phase && (told.phase === "start" || (state?.phase ?? "start") === "start")) {
    turn(told.phase === "start" ? 1 : -1); // what most designs begin with
  }
  state = told;
  if (changed) {
    sheet = told.sheet;
    board?.show(told.sheet);
    folding.take(told.sheet, told.worth);
    folding.pins([]);
    board?.marks([]);
    get("figures").textContent = "";
    moving = null;
  } else {
    folding.worth(told.worth);
    folding.show();
  }
  folding.ghost(null);
  board?.ghost(partners.looked === null ? [] : (partners.offers[partners.looked]?.creases ?? []));
  board?.light(told);
  tip("", "");
  const worth = told.worth ? number(told.worth.value, 4) : told.scoring ? "…" : "–";
  const mm = told.worth && game?.distance && game.cell_mm ? ` (${number(-told.worth.value * game.cell_mm, 2)} mm)` : "";
  const facts: [string, string][] = [
    ["return", worth + mm],
    ["best at", told.worth && told.creases ? `${number(told.worth.angle, 0)}°` : "–"],
    ["panels", String(told.panels)],
    ["creases", String(told.creases)],
    ["vertices", String(told.vertices)],
  ];
  get("facts").replaceChildren(
    ...facts.map(([key, value]) => {
      const row = document.createElement("div");
      row.append(Object.assign(document.createElement("dt"), { textContent: key }));
      row.append(Object.assign(document.createElement("dd"), { textContent: value, id: `fact-${key.replace(" ", "-")}` }));
      return row;
    }),
  );
  get<HTMLButtonElement>("undo").disabled = !told.undo && !told.selected;
  get<HTMLButtonElement>("redo").disabled = !told.redo;
  get<HTMLButtonElement>("back").disabled = !told.selected;
  get("save").textContent = told.unsaved ? "Save •" : "Save";
  if (told.note) say(told.note);
  else if (changed && !isFirst) say("");
  guide();
  connection.point(board?.cursor ?? null);
}

function guide(): void {
  if (!state) return;
  const hints: Record<Tool, string> = {
    play: state.ended ?? NEXT[state.phase],
    source: state.sources.length ? "choose a lit boundary segment for a driven crease" : "no driven crease may be laid here",
    cut: "choose a vertex: its extension goes, and what grew from it",
    move: moving ? "choose where it shall go" : "drag a vertex to another place, or choose it and then the place",
    region: `choose vertices that “Repair selected” may grow anew (${board?.region.size ?? 0} selected)`,
  };
  get("next").textContent = hints[board?.tool ?? "play"];
}

function pointed(told: TellPointed): void {
  if (!board || board.tool !== "play" || !state) return;
  const isVertex = state.phase !== "leaf" || at(board.cursor);
  if (!isVertex) return;
  board.pointAt(board.cursor, told.legal ? "legal" : "illegal");
  const kept = partners.looked === null ? [] : (partners.offers[partners.looked]?.creases ?? []);
  board.ghost(told.ghost?.creases ?? kept, told.places as Point[]);
  folding.ghost(told.ghost as Ghost | null);
  tip(told.says ?? "", told.legal ? (told.says ? "short" : "") : "wrong");
}

function figures(told: TellMeasured): string {
  const found: string[] = [];
  const cell = game?.cell_mm;
  for (const [key, value] of Object.entries(told.figures)) {
    const mm = cell && key.startsWith("return_") && !key.endsWith("percent") && !key.endsWith("units") ? ` (${number(Math.abs(value) * cell, 2)} mm)` : "";
    if (key !== "return_own") found.push(`${key.replace("return_", "")} ${number(value, key.endsWith("percent") ? 2 : 4)}${key.endsWith("percent") ? " %" : mm}`);
  }
  if (told.sharpest !== null) found.push(`smallest angle ${number(told.sharpest, 1)}°`);
  if (told.narrowest !== null) found.push(`narrowest panel ${number(told.narrowest, 2)} cells`);
  for (const [name, mark] of [["sheet", told.sheet], ["target", told.target]] as const) {
    if (mark) found.push(`${name} furthest away by ${number(mark.distance, 3)}${mark.board ? ` at (${mark.board.join(", ")})` : ""}`.replace(/-/g, "−"));
  }
  return found.join(" · ");
}

// --- what is asked for ---

// Whether there is a vertex at a board point.
function at(point: Point | null): boolean {
  return !!point && !!sheet && sheet.vertices.some(([x, y]) => x === point[0] && y === point[1]);
}

function point(where: Point | null): void {
  if (!where || (state?.phase === "leaf" && !at(where)) || board?.tool !== "play") {
    tip("", "");
    folding.ghost(null);
    board?.ghost(partners.looked === null ? [] : (partners.offers[partners.looked]?.creases ?? []));
    connection.point(null);
    return;
  }
  connection.point(where);
}

function choose(where: Point): void {
  if (!state || !board) return;
  switch (board.tool) {
    case "play":
      if (state.phase === "start" && state.placements.length) ask({ kind: "start", option: nearestOutline(where), sign });
      else if (state.phase === "leaf" && !at(where)) say("there is no vertex here: choose a ringed leaf", true);
      else if (state.phase === "leaf") ask({ kind: "select", at: where, mode: sign });
      else ask({ kind: "place", at: where });
      return;
    case "source": {
      const found = nearestSource(where);
      if (found !== null) ask({ kind: "source", number: found, sign });
      return;
    }
    case "cut":
      ask({ kind: "cut", points: [where] });
      return;
    case "move":
      if (moving) ask({ kind: "shift", at: moving, to: where });
      else if (at(where)) moving = where;
      guide();
      return;
    case "region": {
      if (!at(where)) return say("there is no vertex here", true);
      for (const image of board.images(where)) {
        const key = String(image);
        if (!board.region.delete(key)) board.region.add(key);
      }
      board.light(state);
      guide();
    }
  }
}

const away = ([x, y]: Point, [a, b]: Point, [c, d]: Point): number => {
  const [u, v] = [c - a, d - b];
  const t = Math.max(0, Math.min(1, ((x - a) * u + (y - b) * v) / (u * u + v * v || 1)));
  return Math.hypot(x - a - t * u, y - b - t * v);
};

function nearestOutline(where: Point): number {
  const outlines = state!.placements as Point[][];
  const distance = (outline: Point[]) => Math.min(...outline.map((p, k) => away(where, p, outline[(k + 1) % outline.length])));
  return outlines.reduce((best, outline, k) => (distance(outline) < distance(outlines[best]) ? k : best), 0);
}

function nearestSource(where: Point): number | null {
  let [best, least] = [null as number | null, 1.2];
  for (const { number: k, ends } of state!.sources) {
    const [a, b] = ends.map((end) => board!.images(end as Point));
    a.forEach((image, j) => {
      const distance = away(where, image, b[j] ?? b[0]);
      if (distance < least) [best, least] = [k, distance];
    });
  }
  return best;
}

// --- the rest of the page ---

function say(text: string, wrong = false): void {
  get("status").textContent = text;
  get("status").classList.toggle("wrong", wrong);
}

function tip(text: string, how: string): void {
  get("tip").hidden = !text;
  get("tip").textContent = text;
  get("tip").className = how;
}

function use(tool: Tool): void {
  if (!board) return;
  board.tool = tool;
  moving = null;
  if (tool !== "region") board.region.clear();
  for (const button of document.querySelectorAll<HTMLElement>("[data-tool]")) {
    button.setAttribute("aria-pressed", String(button.dataset.tool === tool));
  }
  if (state) board.light(state);
  board.ghost([]);
  tip("", "");
  guide();
}

function turn(to: -1 | 1): void {
  sign = to;
  for (const button of document.querySelectorAll<HTMLElement>("[data-sign]")) {
    button.setAttribute("aria-pressed", String(Number(button.dataset.sign) === sign));
  }
}

function showBeside(): void {
  folding.besideBest = pinned?.worth?.angle ?? null;
  folding.lay(pinned?.sheet ?? null);
  if (!pinned) return;
  get("besideTitle").textContent = `kept for comparison${pinned.worth ? `: return ${number(pinned.worth.value, 4)}` : ""}`;
  get("besideActions").hidden = true;
}

function download(name: string, content: string): void {
  const bytes = Uint8Array.from(atob(content), (letter) => letter.charCodeAt(0));
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([bytes]));
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
  say(`written beside the saved design, and downloaded: ${name}`);
}

for (const button of document.querySelectorAll<HTMLElement>("[data-tool]")) {
  button.addEventListener("click", () => use(button.dataset.tool as Tool));
}
for (const button of document.querySelectorAll<HTMLElement>("[data-sign]")) {
  button.addEventListener("click", () => turn(Number(button.dataset.sign) as -1 | 1));
}
for (const kind of ["back", "undo", "redo"] as const) get(kind).addEventListener("click", () => ask({ kind }));
get("end").addEventListener("click", () => ask({ kind: "terminate" }));
get("save").addEventListener("click", () => ask({ kind: "save" }));
get("export").addEventListener("click", () => ask({ kind: "export", format: get<HTMLSelectElement>("format").value }));
get("help").addEventListener("click", () => get<HTMLDialogElement>("keys").showModal());
get("compare").addEventListener("click", () => {
  pinned = pinned || !sheet || !state ? null : { sheet, worth: state.worth };
  get("compare").setAttribute("aria-pressed", String(!!pinned));
  if (partners.looked === null) showBeside();
});
get("leave").addEventListener("click", () => {
  if (state?.unsaved && !confirm("This design is not saved. Leave it?")) return;
  get("gallery").hidden = false;
  get("studio").hidden = true;
  get("begin").hidden = false;
  get("opening").textContent = "";
});
addEventListener("beforeunload", (event) => {
  if (state?.unsaved && !get("studio").hidden) event.preventDefault();
});
addEventListener("keydown", (event) => {
  const typing = event.target instanceof HTMLSelectElement || event.target instanceof HTMLInputElement;
  if (get("studio").hidden || get<HTMLDialogElement>("keys").open || event.altKey || (typing && !event.ctrlKey)) return;
  const key = event.key.toLowerCase();
  if (event.ctrlKey || event.metaKey) {
    if (key !== "z" && key !== "y") return;
    event.preventDefault();
    ask({ kind: key === "y" || event.shiftKey ? "redo" : "undo" });
    return;
  }
  const tools: Record<string, Tool> = { p: "play", s: "source", d: "cut", m: "move", g: "region" };
  if (tools[key]) use(tools[key]);
  else if (key === "v") turn(sign > 0 ? -1 : 1);
  else if (key === "u") ask({ kind: "undo" });
  else if (key === "r") ask({ kind: "redo" });
  else if (key === "t") ask({ kind: "terminate" });
  else if (key === "?") get<HTMLDialogElement>("keys").showModal();
  else if (key === "delete" && board?.cursor) ask({ kind: "cut", points: [board.cursor] });
  else if (key === "escape") {
    if (board?.tool !== "play") use("play");
    else if (state?.selected) ask({ kind: "back" });
  }
});

// for whoever drives the page from outside
Object.assign(window, {
  studioWhere: (at: Point) => board?.where(at),
  studioTold: () => told,
  studioState: () => state,
  studioHalf: () => game?.half,
  studioOffered: () => [
    ...(state?.places ?? []).map((place) => place.at),
    ...(state?.phase === "leaf" ? state.leaves : []).filter((leaf) => !leaf.says).map((leaf) => leaf.at),
    ...(state?.placements ?? []).map((outline) => outline[0]),
  ],
});
