// What the server and the exported page hold of a sheet: made by origami_lab/drawing/viewer.py.

import type { Packed, SheetData, SheetState } from "./studio/messages";

export type { Packed, SheetData, SheetState };

export type Kind = "panel" | "edge" | "vertex";

export interface Picked {
  kind: Kind;
  index: number;
}

export type OnPick = (picked: Picked | null) => void;

// An element of the page that is there.
export function get<T extends HTMLElement = HTMLElement>(id: string): T {
  const found = document.getElementById(id);
  if (!found) throw new Error(`there is no element #${id}`);
  return found as T;
}

export function number(value: number, digits: number): string {
  return value.toFixed(digits).replace("-", "−").replace(/^−(0\.?0*)$/, "$1");
}
