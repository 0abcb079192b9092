// The folded sheet, the one beside it, and the slider of the driving angle.

import { get, number, type SheetData, type SheetState } from "../data";
import { Motion } from "../motion";
import { Sheet } from "../sheet";
import type { Ghost, Packed, TellMotion, Worth } from "./messages";

const SECONDS = 2.6;
const NEAR_END = 1; // degrees
// Before there is a sheet: the target alone.
const NOTHING: SheetData = {
  vertices: [], modes: null, edges: [], letters: [], driven: null, panels: [], sides: [], triangles: [], owners: [],
  states: [{ at: 0, coords: [], folds: [] }], unit: "°", best: 0, upright: [[1, 0, 0], [0, 1, 0], [0, 0, 1]], target: null,
};

export class Folding {
  motion: Motion | null = null;
  private sheet: Sheet | null = null;
  private beside: Sheet | null = null;
  private besideMotion: Motion | null = null;
  private asked: number | null = null; // by whoever moves the slider
  private best = 0;
  private data: SheetData | null = null;
  private end: TellMotion | null = null;
  private refuted: number[] = []; // panels that meet, by a certificate
  private marked = "";
  private most = 180;
  private target: Packed | null = null;
  private frame = 0;
  private readonly slider = get<HTMLInputElement>("slider");

  constructor(
    private readonly onFold: (motion: Motion, state: SheetState) => void,
    private readonly onMeeting: (panels: number[]) => void,
  ) {
    this.slider.addEventListener("input", () => {
      this.play(false);
      this.asked = Number(this.slider.value);
      this.show();
    });
    get("best").addEventListener("click", () => {
      this.play(false);
      this.asked = null;
      this.show();
    });
    get("toEnd").addEventListener("click", () => {
      this.play(false);
      this.asked = this.end?.free_to ?? null;
      this.show();
    });
    get("play").addEventListener("click", () => this.play(!this.frame));
    get("home").addEventListener("click", () => {
      this.sheet?.home();
      this.beside?.home();
    });
    get<HTMLInputElement>("target").addEventListener("change", () => this.#showTarget());
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.show());
  }

  // Another game.
  open(target: Packed | null, most: number): void {
    this.play(false);
    this.target = target;
    this.most = most;
    this.asked = null;
    this.slider.max = String(most);
    get("targets").hidden = !target;
    for (const id of ["sheet", "besideSheet"]) get(id).replaceChildren();
    this.sheet = this.beside = null;
    this.motion = this.besideMotion = null;
  }

  take(data: SheetData | null, worth: Worth | null): void {
    const drawn = data ?? NOTHING;
    this.data = data;
    this.end = null;
    this.refuted = [];
    this.worth(worth);
    const motion = new Motion(drawn);
    this.marked = "";
    this.onMeeting([]);
    if (data || this.target) this.sheet = this.#made("sheet", this.sheet, drawn, motion);
    this.motion = data ? motion : null;
    if (!data) this.sheet?.show(motion.state(0));
    const zone = get("zone");
    zone.style.setProperty("--reach", String(this.motion ? this.motion.last / this.most : 0));
    zone.dataset.ends = "";
    this.#says("");
    this.show();
  }

  // What the sheet is worth: its best driving angle, and halfway for one in which nothing folds.
  worth(worth: Worth | null): void {
    const folds = !!this.data?.letters.some((letter) => letter !== "B");
    this.best = folds ? (worth?.angle ?? 0) : this.most / 2;
    get("best").style.setProperty("--part", String(this.best / this.most));
    get("best").hidden = !worth || !folds;
  }

  // Panels that a certificate says to meet.
  refute(panels: number[]): void {
    this.refuted = panels;
    this.show();
  }

  #says(text: string): void {
    get("motionSays").textContent = text;
    get("toEnd").hidden = this.end?.ends !== "collides";
  }

  // What is laid beside it; null for nothing.
  lay(data: SheetData | null): void {
    if (data) {
      this.besideMotion = new Motion(data);
      get("beside").hidden = false; // first: a canvas needs a size
      this.beside = this.#made("besideSheet", this.beside, data, this.besideMotion);
      this.show();
    } else {
      get("beside").hidden = true;
      this.besideMotion = null;
    }
  }

  #made(id: string, present: Sheet | null, data: SheetData, motion: Motion): Sheet | null {
    try {
      const made = present ?? new Sheet(get(id), { ...data, target: this.target }, motion, () => {});
      if (present) present.change(data, motion);
      made.showTarget(get<HTMLInputElement>("target").checked);
      return made;
    } catch (error) {
      get(id).textContent = `The folded sheet cannot be shown: ${(error as Error).message}`; // no WebGL
      return null;
    }
  }

  #showTarget(): void {
    const shown = get<HTMLInputElement>("target").checked;
    this.sheet?.showTarget(shown);
    this.beside?.showTarget(shown);
  }

  get at(): number {
    const wanted = this.asked ?? this.best;
    return this.motion ? Math.min(wanted, this.motion.last) : 0;
  }

  show(): void {
    const { motion, at } = this;
    if (motion) {
      const state = motion.state(at);
      this.sheet?.show(state);
      this.onFold(motion, state);
    }
    if (this.besideMotion) {
      const wanted = this.asked ?? this.besideBest ?? this.best;
      this.beside?.show(this.besideMotion.state(Math.min(wanted, this.besideMotion.last)));
    }
    this.#mark(at);
    this.slider.value = String(at);
    this.slider.setAttribute("aria-valuetext", `${number(at, 1)}°`);
    get("angle").textContent = `${number(at, 1)}°`;
  }

  besideBest: number | null = null;

  // The panels that meet, on both sides: those of a certificate, or where the slider is at the end of the motion.
  #mark(at: number): void {
    const isAtEnd = this.end?.ends === "collides" && this.asked !== null && at >= this.end.free_to - NEAR_END;
    const panels = isAtEnd ? this.end!.panels : this.refuted;
    if (String(panels) === this.marked) return;
    this.marked = String(panels);
    this.sheet?.showMeeting(panels);
    this.onMeeting(panels);
  }

  ends(told: TellMotion): void {
    this.end = told;
    if (this.data) this.motion = new Motion({ ...this.data, states: [...this.data.states, ...told.further] });
    const zone = get("zone");
    zone.style.setProperty("--reach", String(told.free_to / this.most));
    zone.dataset.ends = told.ends;
    const end = `${number(told.free_to, 1)}°`;
    const says = { collides: `folds to ${end}, where panels first collide`, closes: `folds to ${end}, where a vertex no longer closes`, whole: `folds all the way to ${end}` };
    this.#says(says[told.ends]);
    this.show();
  }

  ghost(ghost: Ghost | null): void {
    this.sheet?.showAddition(ghost);
  }

  pins(places: number[][]): void {
    this.sheet?.showPins(places);
  }

  play(on: boolean): void {
    cancelAnimationFrame(this.frame);
    this.frame = 0;
    const button = get("play");
    button.setAttribute("aria-label", on ? "pause" : "play");
    button.dataset.playing = String(on);
    if (!on || !this.motion) return;
    let began: number | null = null;
    const step = (time: number) => {
      const last = this.motion?.last ?? 0;
      began ??= time - 1000 * SECONDS * (last ? this.at / last : 0);
      const part = ((time - began) / 1000 / SECONDS) % 2;
      this.asked = last * (part < 1 ? part : 2 - part);
      this.show();
      this.frame = requestAnimationFrame(step);
    };
    this.frame = requestAnimationFrame(step);
  }
}
