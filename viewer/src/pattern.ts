// The flat crease pattern, as SVG.

import type { Kind, OnPick, Picked, SheetData, SheetState } from "./data";
import type { Motion } from "./motion";

const NAMES: Record<string, string> = { M: "mountain", V: "valley", F: "flat", J: "flat", U: "unassigned", B: "boundary", C: "cut" };

export type Attributes = Record<string, string | number>;

export function element(name: string, attributes: Attributes, parent: Element): SVGElement {
  const made = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, String(value));
  parent.append(made);
  return made;
}

export class Pattern {
  readonly svg: SVGElement;
  private readonly marks: Record<Kind, SVGElement[]>;
  private readonly creases: SVGElement[];
  private readonly driven: boolean[] | null;
  private marked: SVGElement | null = null;

  // `box` is what is shown (x, y, width, height; y runs down), by default the sheet with a margin.
  constructor(host: Element, data: SheetData, onPick: OnPick, box?: number[]) {
    const { vertices, edges, panels } = data;
    const xs = vertices.map((v) => v[0]);
    const ys = vertices.map((v) => -v[1]); // y runs down in SVG
    const [left, top] = [Math.min(...xs), Math.min(...ys)];
    const [width, height] = [Math.max(...xs) - left, Math.max(...ys) - top];
    const size = Math.max(width, height);
    const margin = 0.05 * size;
    const own = [left - margin, top - margin, width + 2 * margin, height + 2 * margin];
    const view = (box ?? own).join(" ");
    const svg = element("svg", { viewBox: view, role: "img", "aria-label": "crease pattern" }, host);
    this.svg = svg;
    this.marks = { panel: [], edge: [], vertex: [] };
    const mark = (kind: Kind, index: number, shape: SVGElement, target = shape) => {
      this.marks[kind][index] = shape;
      target.dataset.kind = kind;
      target.dataset.index = String(index);
    };
    panels.forEach((panel, k) => {
      const points = panel.map((v) => `${xs[v]},${ys[v]}`).join(" ");
      mark("panel", k, element("polygon", { points, class: "panel" }, svg));
    });
    const ends = ([u, v]: number[]) => ({ x1: xs[u], y1: ys[u], x2: xs[v], y2: ys[v] });
    const hits: [string, Attributes, Kind, number, SVGElement][] = [];
    this.creases = edges.map((edge, k) => {
      const line = element("line", { ...ends(edge), class: "crease" }, svg);
      hits.push(["line", { ...ends(edge), class: "hit", "stroke-width": 0.025 * size }, "edge", k, line]);
      return line;
    });
    vertices.forEach((_, k) => {
      const mode = data.modes ? ["minus", "leaf", "plus"][data.modes[k] + 1] : "leaf";
      const place = { cx: xs[k], cy: ys[k] };
      const dot = element("circle", { ...place, r: (mode === "leaf" ? 0.006 : 0.0095) * size, class: mode }, svg);
      hits.push(["circle", { ...place, r: 0.022 * size, class: "hit" }, "vertex", k, dot]);
    });
    for (const [name, attributes, kind, k, shape] of hits) mark(kind, k, shape, element(name, attributes, svg));
    this.driven = data.driven;
    const pick = (event: Event) => {
      const { kind, index } = (event.target as SVGElement).dataset;
      onPick(kind ? { kind: kind as Kind, index: Number(index) } : null);
    };
    svg.addEventListener("pointermove", pick);
    svg.addEventListener("pointerdown", pick);
    svg.addEventListener("pointerleave", (event) => {
      if ((event as PointerEvent).pointerType === "mouse") onPick(null);
    });
  }

  show(motion: Motion, state: SheetState): void {
    this.creases.forEach((line, k) => {
      const driven = this.driven && this.driven[k] ? " driven" : "";
      line.setAttribute("class", `crease ${NAMES[motion.letter(state, k)]}${driven}`);
    });
    this.marked?.classList.add("picked");
  }

  highlight(picked: Picked | null): void {
    if (this.marked) this.marked.classList.remove("picked");
    this.marked = picked && this.marks[picked.kind][picked.index];
    if (this.marked) this.marked.classList.add("picked");
  }
}

export { NAMES };
