// The folding motion: stored states by increasing driving angle (or step, where a file says no angles).

import type { SheetData, SheetState } from "./data";

// Between states that are this near (degrees) one moves in straight lines: a panel that turns by 5° shrinks by 0.1 % on
// the way. Where states are further apart the nearest one is shown.
const NEAR = 5;

export class Motion {
  readonly states: SheetState[];
  readonly letters: string[];
  readonly unit: string;
  readonly last: number;
  readonly best: number;

  constructor(data: SheetData) {
    this.states = data.states;
    this.letters = data.letters;
    this.unit = data.unit;
    this.last = this.states[this.states.length - 1].at;
    this.best = data.best;
  }

  // Coordinates (3 numbers a vertex), fold angles (degrees) and the place itself at `at`.
  state(at: number): SheetState {
    const { states } = this;
    const next = states.findIndex((state) => state.at >= at);
    if (next < 0) return states[states.length - 1];
    if (next === 0 || states[next].at === at) return states[next];
    const [a, b] = [states[next - 1], states[next]];
    const part = (at - a.at) / (b.at - a.at);
    if (this.unit !== "°" || b.at - a.at > NEAR) return part < 0.5 ? a : b;
    const mix = (p: number[], q: number[]) => p.map((value, k) => value + (q[k] - value) * part);
    return { at, coords: mix(a.coords, b.coords), folds: mix(a.folds, b.folds) };
  }

  // The crease's letter in a state: what is flat for the moment keeps that of the pattern.
  letter(state: SheetState, edge: number): string {
    const letter = this.letters[edge];
    if (!"MV".includes(letter) || Math.abs(state.folds[edge]) < 1e-4) return letter;
    return state.folds[edge] > 0 ? "V" : "M";
  }
}
