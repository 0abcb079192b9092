// The board: the crease pattern as in the viewer, and over it what may be chosen, pointed at and added.

import type { SheetData, SheetState } from "../data";
import type { Motion } from "../motion";
import { element, Pattern } from "../pattern";
import type { TellBoard, TellOpened } from "./messages";

export type Point = [number, number];
export type Tool = "play" | "source" | "cut" | "move" | "region";

const same = (a: Point | null, b: Point | null) => a === b || (!!a && !!b && a[0] === b[0] && a[1] === b[1]);

export class Board {
  tool: Tool = "play";
  readonly region = new Set<string>();
  cursor: Point | null = null;
  private readonly under: SVGElement;
  private readonly over: SVGElement;
  private readonly layers: Record<"meeting" | "lit" | "ghost" | "chosen" | "marks" | "cursor", SVGElement>;
  private pattern: Pattern | null = null;
  private data: SheetData | null = null;
  private readonly half: Point;
  private readonly box: number[];
  private dragged: Point | null = null;

  constructor(
    private readonly host: HTMLElement,
    private readonly game: TellOpened,
    private readonly onPoint: (at: Point | null) => void,
    private readonly onChoose: (at: Point) => void,
  ) {
    host.replaceChildren();
    this.half = game.half;
    const [x, y] = [this.half[0] + 0.8, this.half[1] + 0.8];
    this.box = [-x, -y, 2 * x, 2 * y];
    const svg = (name: string) => element("svg", { viewBox: this.box.join(" "), class: name }, host);
    this.under = svg("under");
    this.over = svg("over");
    this.#grid();
    const layer = (name: string) => element("g", { class: name }, this.over);
    this.layers = { meeting: layer("meeting"), marks: layer("marks"), lit: layer("lit"), ghost: layer("ghost"), chosen: layer("chosen"), cursor: layer("cursor") };
    this.#listen();
  }

  #grid(): void {
    const [x, y] = this.half;
    const lines: string[] = [];
    for (let k = -x; k <= x; k += 1) lines.push(`M${k} ${-y}V${y}`);
    for (let k = -y; k <= y; k += 1) lines.push(`M${-x} ${k}H${x}`);
    element("path", { d: lines.join(""), class: "grid" }, this.under);
    // each mirror's axis: the points that a matrix leaves where they are
    for (const [a, b, c, d] of this.game.matrices) {
      if (a * d - b * c > 0) continue;
      const [u, v] = a === 1 ? [1, 0] : a === -1 ? [0, 1] : b === 1 ? [1, 1] : [1, -1];
      const reach = Math.min(u ? x : Infinity, v ? y : Infinity);
      element("line", { x1: -u * reach, y1: v * reach, x2: u * reach, y2: -v * reach, class: "axis" }, this.under);
    }
    const step = Math.max(2, 2 * Math.round(Math.max(x, y) / 8));
    for (let k = -Math.floor(x / step) * step; k <= x; k += step) this.#label(k, -y - 0.5, k);
    for (let k = -Math.floor(y / step) * step; k <= y; k += step) if (k > -y) this.#label(-x - 0.35, k - 0.12, k);
  }

  #label(x: number, y: number, value: number): void {
    const said = element("text", { x, y: -y, class: "coordinate", "font-size": 0.034 * this.half[0] + 0.12 }, this.under);
    said.textContent = String(value).replace("-", "−");
  }

  // --- what is shown ---

  show(data: SheetData | null): void {
    this.pattern?.svg.remove();
    this.pattern = null;
    this.data = data;
    if (!data) return;
    this.pattern = new Pattern(this.host, data, () => {}, this.box);
    this.pattern.svg.setAttribute("class", "sheet");
    this.host.insertBefore(this.pattern.svg, this.over);
  }

  fold(motion: Motion, state: SheetState): void {
    this.pattern?.show(motion, state);
  }

  // What may be chosen now.
  light(board: TellBoard): void {
    const { lit, chosen } = this.layers;
    for (const layer of [lit, chosen]) layer.replaceChildren();
    if (this.tool === "play") {
      board.placements.forEach((outline) => this.#polygon(outline, "outline", lit));
      for (const { at, reach } of board.places) {
        const short = board.phase === "third" && reach < board.reach ? " short" : "";
        this.#images(at, (p, k) => this.#dot(p, `place${k ? " image" : ""}${short}`, 0.24, lit));
      }
      if (board.phase === "leaf" && !board.ended) {
        for (const { at, says } of board.leaves) {
          if (!says) this.#images(at, (p, k) => this.#dot(p, `leaf-open${k ? " image" : ""}`, 0.2, lit));
        }
      }
    } else if (this.tool === "source") {
      for (const { ends } of board.sources) {
        this.#images(ends[0], (p, k) => this.#line(p, this.#image(ends[1], k), `source${k ? " image" : ""}`, lit));
      }
    }
    if (board.selected) {
      const leaf = board.selected;
      this.#images(leaf, (p, k) => this.#dot(p, `selected${k ? " image" : ""}`, 0.3, chosen));
      for (const child of board.children) {
        this.#images(leaf, (p, k) => {
          this.#line(p, this.#image(child, k), `added${k ? " image" : ""}`, chosen);
          this.#dot(this.#image(child, k), `added${k ? " image" : ""}`, 0.17, chosen);
        });
      }
    }
    this.#showRegion();
  }

  // Creases that would be added, and places that would be legal.
  ghost(creases: number[][], places: Point[] = []): void {
    const { ghost } = this.layers;
    ghost.replaceChildren();
    for (const [a, b, c, d] of creases) this.#line([a, b], [c, d], "ghost", ghost);
    for (const at of places) this.#images(at, (p, k) => this.#dot(p, `place${k ? " image" : ""}`, 0.2, ghost));
  }

  pointAt(at: Point | null, how: "legal" | "illegal" | "" = ""): void {
    const { cursor } = this.layers;
    cursor.replaceChildren();
    this.cursor = at;
    if (!at) return;
    if (this.dragged && !same(this.dragged, at)) this.#line(this.dragged, at, "shift", cursor);
    this.#dot(at, `cursor ${how}`, 0.34, cursor);
  }

  // Panels that pass through each other.
  meeting(panels: number[]): void {
    const { meeting } = this.layers;
    meeting.replaceChildren();
    const corner = (v: number) => this.data!.vertices[v].slice(0, 2) as Point;
    for (const k of panels) this.#polygon(this.data!.panels[k].map(corner), "meeting", meeting);
  }

  marks(places: number[][]): void {
    const { marks } = this.layers;
    marks.replaceChildren();
    for (const [x, y] of places) this.#dot([x, y], "furthest", 0.45, marks);
  }

  #showRegion(): void {
    for (const key of this.region) {
      this.#dot(key.split(",").map(Number) as Point, "region", 0.36, this.layers.chosen);
    }
  }

  // --- drawing ---

  #image(at: Point, k: number): Point {
    const [a, b, c, d] = this.game.matrices[k];
    return [a * at[0] + b * at[1], c * at[0] + d * at[1]];
  }

  #images(at: Point, draw: (image: Point, k: number) => void): void {
    const seen = new Set<string>();
    this.game.matrices.forEach((_, k) => {
      const image = this.#image(at, k);
      if (seen.has(String(image))) return;
      seen.add(String(image));
      draw(image, k);
    });
  }

  images(at: Point): Point[] {
    const found: Point[] = [];
    this.#images(at, (image) => found.push(image));
    return found;
  }

  #dot(at: Point, name: string, r: number, layer: SVGElement): void {
    element("circle", { cx: at[0], cy: -at[1], r, class: name }, layer);
  }

  #line(a: Point, b: Point, name: string, layer: SVGElement): void {
    element("line", { x1: a[0], y1: -a[1], x2: b[0], y2: -b[1], class: name }, layer);
  }

  #polygon(points: Point[], name: string, layer: SVGElement): void {
    element("polygon", { points: points.map(([x, y]) => `${x},${-y}`).join(" "), class: name }, layer);
  }

  // --- pointing ---

  #at(event: PointerEvent): Point | null {
    const frame = this.over.getBoundingClientRect();
    const [left, top, width, height] = this.box;
    const scale = Math.min(frame.width / width, frame.height / height);
    const x = (event.clientX - frame.left - frame.width / 2) / scale + left + width / 2;
    const y = (event.clientY - frame.top - frame.height / 2) / scale + top + height / 2;
    const at: Point = [Math.round(x) + 0, Math.round(-y) + 0];
    return Math.abs(at[0]) > this.half[0] || Math.abs(at[1]) > this.half[1] ? null : at;
  }

  // Where a board point is on the page, for whoever drives it.
  where(at: Point): Point {
    const frame = this.over.getBoundingClientRect();
    const [left, top, width, height] = this.box;
    const scale = Math.min(frame.width / width, frame.height / height);
    const x = frame.left + frame.width / 2 + (at[0] - left - width / 2) * scale;
    return [x, frame.top + frame.height / 2 + (-at[1] - top - height / 2) * scale];
  }

  #point(at: Point | null): void {
    if (same(at, this.cursor)) return;
    this.pointAt(at);
    this.onPoint(at);
  }

  #listen(): void {
    const { over } = this;
    over.addEventListener("pointermove", (event) => this.#point(this.#at(event as PointerEvent)));
    over.addEventListener("pointerdown", (event) => {
      const at = this.#at(event as PointerEvent);
      this.dragged = at;
      this.#point(at);
    });
    over.addEventListener("pointerup", (event) => {
      const [from, at] = [this.dragged, this.#at(event as PointerEvent)];
      this.dragged = null;
      if (!at || (event as PointerEvent).button > 0) return;
      if (this.tool === "move" && from && !same(from, at)) this.onDrag(from, at);
      else this.onChoose(at);
    });
    over.addEventListener("pointercancel", () => (this.dragged = null));
    over.addEventListener("pointerleave", () => this.#point(null));
    this.host.addEventListener("keydown", (event) => {
      const steps: Record<string, Point> = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
      const step = steps[event.key];
      if (step) {
        event.preventDefault();
        const [x, y] = this.cursor ?? [0, 0];
        const clamp = (value: number, most: number) => Math.max(-most, Math.min(most, value));
        this.#point([clamp(x + step[0], this.half[0]), clamp(y + step[1], this.half[1])]);
      } else if ((event.key === "Enter" || event.key === " ") && this.cursor) {
        event.preventDefault();
        this.onChoose(this.cursor);
      }
    });
  }

  onDrag: (from: Point, to: Point) => void = () => {};
}
