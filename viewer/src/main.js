// The viewer of one design: its crease pattern, its folded sheet, its motion.

import { Motion } from "./motion.js";
import { NAMES, Pattern } from "./pattern.js";
import { Sheet } from "./sheet.js";

const get = (id) => document.getElementById(id);
const data = JSON.parse(get("design").textContent);
const motion = new Motion(data);
const [SECONDS, HOLD] = [2.6, 0.7]; // from flat to the best state, and how long it stays at both ends

let at = motion.best;
let picked = null;
let sheet = null;

const pattern = new Pattern(get("pattern"), data, pick);
try {
  sheet = new Sheet(get("sheet"), data, motion, pick);
} catch (error) {
  get("sheet").append(`The folded sheet cannot be shown: ${error.message}`); // no WebGL: the pattern still works
}

function number(value, digits) {
  return value.toFixed(digits).replace("-", "−").replace(/^−(0\.?0*)$/, "$1");
}

function place(value) {
  return motion.unit === "°" ? `${number(value, 1)}°` : `step ${Math.round(value)}`;
}

function describe() {
  if (!picked) return get("hint").textContent;
  const { kind, index } = picked;
  const { folds } = motion.state(at);
  const fold = (edge) => `${number(folds[edge], 1)}°`;
  const isCrease = (edge) => !"BC".includes(motion.letters[edge]);
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

function pick(found) {
  if (found?.kind === picked?.kind && found?.index === picked?.index) return;
  picked = found;
  pattern.highlight(picked);
  sheet?.highlight(picked);
  get("said").textContent = describe();
}

function show(value) {
  at = Math.min(Math.max(value, 0), motion.last);
  const state = motion.state(at);
  pattern.show(motion, state);
  sheet?.show(state);
  get("slider").value = at;
  get("slider").setAttribute("aria-valuetext", place(at));
  get("angle").textContent = place(state.at);
  get("said").textContent = describe();
}

let playing = null;

function play(on) {
  cancelAnimationFrame(playing?.frame);
  playing = on ? { frame: 0, began: null } : null;
  get("play").setAttribute("aria-pressed", on);
  get("play").setAttribute("aria-label", on ? "pause" : "play");
  get("play").dataset.playing = on;
  if (!on) return;
  const round = 2 * (SECONDS + HOLD);
  const step = (now) => {
    // begin where the sheet is, on its way up; from the best state on its way down
    playing.began ??= now - 1000 * (at < motion.best ? HOLD + SECONDS * (at / motion.best) : 2 * HOLD + SECONDS);
    const time = ((now - playing.began) / 1000) % round;
    const up = Math.min(Math.max((time - HOLD) / SECONDS, 0), 1);
    const down = Math.min(Math.max((time - 2 * HOLD - SECONDS) / SECONDS, 0), 1);
    show(motion.best * (up - down));
    playing.frame = requestAnimationFrame(step);
  };
  playing.frame = requestAnimationFrame(step);
}

function readAddress() {
  const asked = parseFloat(new URLSearchParams(location.hash.slice(1)).get("angle"));
  if (Number.isFinite(asked)) {
    play(false);
    show(asked);
  }
}

const slider = get("slider");
slider.max = motion.last;
slider.disabled = !(motion.last > 0);
get("play").disabled = !(motion.best > 0);
get("best").style.setProperty("--part", motion.last > 0 ? motion.best / motion.last : 0);
get("best").title = `best: ${place(motion.best)}`;
get("best").addEventListener("click", () => {
  play(false);
  show(motion.best);
});
slider.addEventListener("input", () => {
  play(false);
  show(Number(slider.value));
});
get("play").addEventListener("click", () => play(!playing));
get("home").addEventListener("click", () => sheet?.home());
if (data.target) {
  get("target").addEventListener("change", (event) => sheet?.showTarget(event.target.checked));
} else {
  get("targets").remove();
}
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => show(at));
window.addEventListener("hashchange", readAddress);
show(at);
readAddress();
