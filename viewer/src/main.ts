// The viewer of one design: its crease pattern, its folded sheet, its motion.

import { get, number, type Picked, type SheetData } from "./data";
import { Motion } from "./motion";
import { NAMES, Pattern } from "./pattern";
import { Sheet } from "./sheet";

const data = JSON.parse(get("design").textContent ?? "") as SheetData;
const motion = new Motion(data);
const [SECONDS, HOLD] = [2.6, 0.7]; // from flat to the best state, and how long it stays at both ends

let at = motion.best;
let picked: Picked | null = null;
let sheet: Sheet | null = null;

const slider = get<HTMLInputElement>("slider");
const playButton = get<HTMLButtonElement>("play");
const pattern = new Pattern(get("pattern"), data, pick);
try {
  sheet = new Sheet(get("sheet"), data, motion, pick);
} catch (error) {
  get("sheet").append(`The folded sheet cannot be shown: ${(error as Error).message}`); // no WebGL: the pattern still works
}

function place(value: number): string {
  return motion.unit === "°" ? `${number(value, 1)}°` : `step ${Math.round(value)}`;
}

function describe(): string | null {
  if (!picked) return get("hint").textContent;
  const { kind, index } = picked;
  const { folds } = motion.state(at);
  const fold = (edge: number) => `${number(folds[edge], 1)}°`;
  const isCrease = (edge: number) => !"BC".includes(motion.letters[edge]);
  if (kind === "vertex") {
    const [x, y] = data.vertices[index].map((value) => String(Math.round(value * 1000) / 1000).replace("-", "−"));
    const mode = data.modes ? data.modes[index] : null;
    const words = mode === null ? "" : mode ? ` · rigid body mode M = ${mode > 0 ? "+1" : "−1"}` : " · a leaf, not extended";
    return `vertex ${index} at (${x}, ${y})${words}`;
  }
  if (kind === "edge") {
    const [u, v] = data.edges[index];
    if (!isCrease(index)) return `${NAMES[motion.letters[index]]} ${u}–${v}`;
    const driven = data.driven && data.driven[index] ? " driven" : "";
    return `${NAMES[motion.letter(motion.state(at), index)]}${driven} crease ${u}–${v} · fold angle ${fold(index)}`;
  }
  const creases = data.sides[index].filter(isCrease);
  return `panel ${index} · fold angles at its creases ${creases.map(fold).join(", ") || "none"}`;
}

function pick(found: Picked | null): void {
  if (found?.kind === picked?.kind && found?.index === picked?.index) return;
  picked = found;
  pattern.highlight(picked);
  sheet?.highlight(picked);
  get("said").textContent = describe();
}

function show(value: number): void {
  at = Math.min(Math.max(value, 0), motion.last);
  const state = motion.state(at);
  pattern.show(motion, state);
  sheet?.show(state);
  slider.value = String(at);
  slider.setAttribute("aria-valuetext", place(at));
  get("angle").textContent = place(state.at);
  get("said").textContent = describe();
}

let playing: { frame: number; began: number | null } | null = null;

function play(on: boolean): void {
  if (playing) cancelAnimationFrame(playing.frame);
  const now: typeof playing = on ? { frame: 0, began: null } : null;
  playing = now;
  playButton.setAttribute("aria-pressed", String(on));
  playButton.setAttribute("aria-label", on ? "pause" : "play");
  playButton.dataset.playing = String(on);
  if (!now) return;
  const round = 2 * (SECONDS + HOLD);
  const step = (time: number) => {
    // begin where the sheet is, on its way up; from the best state on its way down
    now.began ??= time - 1000 * (at < motion.best ? HOLD + SECONDS * (at / motion.best) : 2 * HOLD + SECONDS);
    const passed = ((time - now.began) / 1000) % round;
    const up = Math.min(Math.max((passed - HOLD) / SECONDS, 0), 1);
    const down = Math.min(Math.max((passed - 2 * HOLD - SECONDS) / SECONDS, 0), 1);
    show(motion.best * (up - down));
    now.frame = requestAnimationFrame(step);
  };
  now.frame = requestAnimationFrame(step);
}

function readAddress() {
  const asked = parseFloat(new URLSearchParams(location.hash.slice(1)).get("angle") ?? "");
  if (Number.isFinite(asked)) {
    play(false);
    show(asked);
  }
}

slider.max = String(motion.last);
slider.disabled = !(motion.last > 0);
playButton.disabled = !(motion.best > 0);
get("best").style.setProperty("--part", String(motion.last > 0 ? motion.best / motion.last : 0));
get("best").title = `best: ${place(motion.best)}`;
get("best").addEventListener("click", () => {
  play(false);
  show(motion.best);
});
slider.addEventListener("input", () => {
  play(false);
  show(Number(slider.value));
});
playButton.addEventListener("click", () => play(!playing));
get("home").addEventListener("click", () => sheet?.home());
if (data.target) {
  get("target").addEventListener("change", (event) => sheet?.showTarget((event.target as HTMLInputElement).checked));
} else {
  get("targets").remove();
}
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => show(at));
window.addEventListener("hashchange", readAddress);
show(at);
readAddress();
