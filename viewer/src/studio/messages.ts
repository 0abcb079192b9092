// Made of origami_lab/studio/messages.py and replies.py by `npm run types`: not to be changed by hand.

// Take the extensions of vertices away, and what grew from them.
export interface AskCut {
  kind: "cut";
  points: [number, number][];
}

// Save, and write the design in another format.
export interface AskExport {
  kind: "export";
  format: string;
}

// Begin a design for a task of the gallery.
export interface AskOpen {
  kind: "open";
  task: string;
  start: string;
}

// Have a partner work on the design.
export interface AskPartner {
  kind: "partner";
  task: "suggest" | "finish" | "improve" | "repair" | "certify" | "measure" | "polish" | "simplify";
  searcher?: string;
  budget?: number;
  region?: [number, number][];
}

// Place the next child, or the next corner of the start pattern.
export interface AskPlace {
  kind: "place";
  at: [number, number];
}

// The board point that is pointed at: may it be chosen, why not, and what would come of it.
export interface AskPoint {
  kind: "point";
  id: number;
  at: [number, number];
}

// Look at a proposal of the partner's, take it, or leave all.
export interface AskProposal {
  kind: "look" | "take" | "leave" | "stop";
  number?: number;
}

// Save the design as a run folder.
export interface AskSave {
  kind: "save";
}

// Begin to extend a leaf.
export interface AskSelect {
  kind: "select";
  at: [number, number];
  mode: -1 | 1;
}

// Move a vertex to another board point.
export interface AskShift {
  kind: "shift";
  at: [number, number];
  to: [number, number];
}

// Lay a driven crease on a boundary segment, by its number among those that may have one.
export interface AskSource {
  kind: "source";
  number: number;
  sign: -1 | 1;
}

// Lay a start pattern.
export interface AskStart {
  kind: "start";
  option: number;
  sign: -1 | 1;
}

// Back by one action, undo, redo, or end the game.
export interface AskStep {
  kind: "back" | "undo" | "redo" | "terminate";
}

export type Request = AskOpen | AskPoint | AskSelect | AskPlace | AskStart | AskSource | AskStep | AskCut | AskShift | AskPartner | AskProposal | AskSave | AskExport;

// A task of the gallery.
export interface GalleryTask {
  name: string;
  group: "target" | "objective";
  says: string;
}

// What would be added: triangles in space at driving angles, and creases on the board.
export interface Ghost {
  angles: number[];
  coords: number[][];
  triangles: number[][];
  creases: number[][];
}

// A vertex of the boundary in the playable area; ``says`` is why it cannot be extended.
export interface Leaf {
  at: [number, number];
  says: string | null;
}

// A place that may be chosen, and how many driving angles the motion reaches then.
export interface LegalPlace {
  at: [number, number];
  reach: number;
}

// A place in space, and on the board where it is one of the sheet's.
export interface Mark {
  at: number[];
  board: number[] | null;
  distance: number;
}

// A surface: vertices and faces as base64 of little-endian float32 and uint32.
export interface Packed {
  vertices: string;
  faces: string;
}

// A design, or a next move, that a partner offers.
export interface Proposal {
  number: number;
  worth: Worth | null;
  says: string;
  creases: number[][];
}

// A sheet as the viewer draws it: the flat pattern, and its states by driving angle.
export interface SheetData {
  vertices: number[][];
  modes: number[] | null;
  edges: number[][];
  letters: string[];
  driven: boolean[] | null;
  panels: number[][];
  sides: number[][];
  triangles: number[][];
  owners: number[];
  states: SheetState[];
  unit: string;
  best: number;
  upright: number[][];
  target: Packed | null;
}

// The folded sheet at one driving angle, in degrees; 3 coordinates a vertex, one fold angle an edge.
export interface SheetState {
  at: number;
  coords: number[];
  folds: number[];
}

// A boundary segment that may have a driven crease.
export interface SourceSegment {
  number: number;
  ends: [number, number][];
}

// Where the design stands.
export interface TellBoard {
  kind: "board";
  revision: number;
  what: string;
  phase: "start" | "leaf" | "first" | "second" | "third";
  ended: string | null;
  sheet: SheetData | null;
  reach: number;
  leaves: Leaf[];
  places: LegalPlace[];
  placements: [number, number][][];
  sources: SourceSegment[];
  selected: [number, number] | null;
  mode: number;
  children: [number, number][];
  worth: Worth | null;
  scoring: boolean;
  undo: number;
  redo: number;
  vertices: number;
  creases: number;
  panels: number;
  unsaved: boolean;
  note: string | null;
}

// What the verification says of a design.
export interface TellCertified {
  kind: "certified";
  revision: number;
  verdict: string;
  says: string;
  panels: number[];
}

// A file of the saved design: its name and its content in base64.
export interface TellExported {
  kind: "exported";
  name: string;
  content: string;
}

// A proposal's sheet.
export interface TellLook {
  kind: "look";
  number: number;
  sheet: SheetData;
  worth: Worth | null;
}

// The figures of a design.
export interface TellMeasured {
  kind: "measured";
  revision: number;
  figures: Record<string, number>;
  sharpest: number | null;
  narrowest: number | null;
  sheet: Mark | null;
  target: Mark | null;
}

// How far the design folds, looked at in tenths of a degree.
export interface TellMotion {
  kind: "motion";
  revision: number;
  free_to: number;
  ends: "collides" | "closes" | "whole";
  panels: number[];
  further: SheetState[];
}

// What a design is for, and in which game it is played.
export interface TellOpened {
  kind: "opened";
  task: string;
  title: string;
  half: [number, number];
  symmetry: string;
  matrices: number[][];
  angles: number[];
  first_angle: number;
  rules: string[];
  searchers: string[];
  formats: string[];
  distance: boolean;
  cell_mm: number | null;
  target: Packed | null;
  polishes: boolean;
}

// What is waited for before a design can be played.
export interface TellOpening {
  kind: "opening";
  says: string;
}

// How far a partner is.
export interface TellPartner {
  kind: "partner";
  task: string;
  running: boolean;
  says: string;
  interactions: number;
  best: number | null;
}

// The answer to a point.
export interface TellPointed {
  kind: "pointed";
  id: number;
  at: [number, number];
  legal: boolean;
  says: string | null;
  places: [number, number][];
  ghost: Ghost | null;
}

// What a partner offers, the best first.
export interface TellProposals {
  kind: "proposals";
  task: string;
  proposals: Proposal[];
}

// What was asked for cannot be done; nothing has changed.
export interface TellRefused {
  kind: "refused";
  says: string;
}

// Where the design is on disk.
export interface TellSaved {
  kind: "saved";
  path: string;
  command: string;
  notes: string[];
}

// The first message: what can be begun.
export interface TellWelcome {
  kind: "welcome";
  tasks: GalleryTask[];
  starts: string[];
  opens: boolean;
}

// The return of a design, and its best driving angle in degrees.
export interface Worth {
  value: number;
  angle: number;
}

export type Reply = TellWelcome | TellOpening | TellOpened | TellBoard | TellPointed | TellMotion | TellPartner | TellProposals | TellLook | TellMeasured | TellCertified | TellSaved | TellExported | TellRefused;
