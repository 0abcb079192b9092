// The folded sheet in space.

import {
  AmbientLight,
  BackSide,
  Box3,
  BufferAttribute,
  BufferGeometry,
  Color,
  DirectionalLight,
  DoubleSide,
  FrontSide,
  Group,
  Matrix4,
  Mesh,
  MeshBasicMaterial,
  MeshLambertMaterial,
  PerspectiveCamera,
  Raycaster,
  Scene,
  type Side,
  SphereGeometry,
  Vector2,
  Vector3,
  WebGLRenderer,
} from "three";
import type { OnPick, Packed, Picked, SheetData, SheetState } from "./data";
import type { Motion } from "./motion";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { LineMaterial } from "three/addons/lines/LineMaterial.js";
import { LineSegments2 } from "three/addons/lines/LineSegments2.js";
import { LineSegmentsGeometry } from "three/addons/lines/LineSegmentsGeometry.js";

const FRONT = 0xf4a858;
const BACK = 0x709ac8;
const TARGET = 0x58be96;
const PICKED = 0xffe14d;
const PIN = 0xd11fa5;
const MEETING = 0xe02030;
const MOUNTAIN = new Color(0xd62828);
const VALLEY = new Color(0x1d5fd1);
const [AZIMUTH, ELEVATION] = [-62, 36].map((degrees) => (degrees * Math.PI) / 180); // as in the pictures
const RIGHT = new Vector3(-Math.sin(AZIMUTH), Math.cos(AZIMUTH), 0);
const TOWARDS = new Vector3(0, 0, Math.sin(ELEVATION)).addScaledVector(
  new Vector3(Math.cos(AZIMUTH), Math.sin(AZIMUTH), 0),
  Math.cos(ELEVATION),
);
const UP = TOWARDS.clone().cross(RIGHT);
const FIELD = 30; // degrees
const [NEAR_VERTEX, NEAR_EDGE] = [9, 5]; // pixels

// The bytes of numbers in base64, little-endian.
function bytes(text: string): ArrayBuffer {
  return Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0)).buffer;
}

// Triangles that would be added, at driving angles.
export interface Addition {
  angles: number[];
  coords: number[][];
  triangles: number[][];
}

export class Sheet {
  private readonly renderer = new WebGLRenderer({ antialias: true, alpha: true });
  private readonly scene = new Scene();
  private readonly camera = new PerspectiveCamera(FIELD, 1, 0.1, 1000);
  private readonly world = new Group(); // turned as the sheet is used
  private readonly controls: OrbitControls;
  private positions = new BufferAttribute(new Float32Array(0), 3);
  private paper: Mesh[] = [];
  private marks!: { panel: Mesh; edge: LineSegments2; vertex: Mesh };
  private lines!: LineSegments2;
  private target: Mesh | null = null;
  private readonly addition: Mesh;
  private readonly meeting: Mesh;
  private added: Addition | null = null;
  private readonly pins: Mesh[] = [];
  private state: SheetState | null = null;
  private picked: Picked | null = null;
  private seen: { points: Vector3[]; box: Box3 } | null = null;
  private moved = false;
  private turning = false;
  private down: [number, number] = [Infinity, Infinity];
  private due: number | undefined;
  private dotSize = 0.1;

  constructor(
    private readonly host: HTMLElement,
    private data: SheetData,
    private motion: Motion,
    onPick: OnPick,
  ) {
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    host.append(this.renderer.domElement);
    this.camera.up.set(0, 0, 1);
    const lamp = new DirectionalLight(0xffffff, 2.1);
    lamp.position.set(-0.5, 0.9, 1.2); // beside the viewer, in the camera's frame
    this.camera.add(lamp);
    this.scene.add(this.camera, new AmbientLight(0xffffff, 1.5));
    this.world.matrixAutoUpdate = false;
    this.scene.add(this.world);
    this.#paper();
    this.addition = new Mesh(
      new BufferGeometry(),
      new MeshBasicMaterial({ color: PICKED, transparent: true, opacity: 0.5, side: DoubleSide, depthWrite: false }),
    );
    this.addition.frustumCulled = false;
    this.addition.visible = false;
    this.meeting = new Mesh(
      new BufferGeometry(),
      new MeshBasicMaterial({ color: MEETING, transparent: true, opacity: 0.75, side: DoubleSide, depthWrite: false }),
    );
    this.meeting.frustumCulled = false;
    this.meeting.visible = false;
    this.world.add(this.addition, this.meeting);
    this.#take(data);
    if (data.target) this.setTarget(data.target);
    this.controls = new OrbitControls(this.camera, this.renderer.domElement);
    this.controls.addEventListener("change", () => this.draw());
    this.#home();
    new ResizeObserver(() => this.#resize()).observe(host);
    this.#listen(onPick);
    this.#resize();
  }

  // Another sheet in place of this one, seen from where it was, or from the usual side if nobody has turned it.
  change(data: SheetData, motion: Motion): void {
    this.data = data;
    this.motion = motion;
    this.picked = null;
    this.seen = null;
    this.state = null;
    this.#take(data);
    if (!this.moved) this.#home();
  }

  #take(data: SheetData): void {
    const [r, s, t] = data.upright;
    this.world.matrix = new Matrix4().set(r[0], r[1], r[2], 0, s[0], s[1], s[2], 0, t[0], t[1], t[2], 0, 0, 0, 0, 1);
    this.world.matrixWorldNeedsUpdate = true;
    this.positions = new BufferAttribute(new Float32Array(3 * data.vertices.length), 3);
    const { geometry } = this.paper[0];
    geometry.dispose(); // its buffers have another size now
    geometry.setAttribute("position", this.positions);
    geometry.setIndex(data.triangles.flat());
    this.marks.panel.geometry.dispose();
    this.marks.panel.geometry.setAttribute("position", this.positions);
    this.meeting.geometry.dispose();
    this.meeting.geometry.setAttribute("position", this.positions);
    this.meeting.visible = false;
    this.lines.geometry.dispose();
    this.lines.geometry = new LineSegmentsGeometry();
  }

  #paper(): void {
    const geometry = new BufferGeometry();
    const offset = { polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 2 }; // behind its lines
    const side = (color: number, which: Side) =>
      new Mesh(geometry, new MeshLambertMaterial({ color, side: which, flatShading: true, ...offset }));
    this.paper = [side(FRONT, FrontSide), side(BACK, BackSide)];
    const mark = new Mesh(
      new BufferGeometry(),
      new MeshBasicMaterial({ color: PICKED, transparent: true, opacity: 0.55, side: DoubleSide, depthWrite: false }),
    );
    this.lines = new LineSegments2(
      new LineSegmentsGeometry(),
      new LineMaterial({ vertexColors: true }),
    );
    const line = new LineSegments2(new LineSegmentsGeometry(), new LineMaterial({ linewidth: 5, color: PICKED }));
    const dot = new Mesh(new SphereGeometry(1, 24, 16), new MeshBasicMaterial({ color: PICKED, depthTest: false }));
    dot.renderOrder = 2;
    this.marks = { panel: mark, edge: line, vertex: dot };
    for (const one of Object.values(this.marks)) one.visible = false;
    for (const mesh of [...this.paper, mark, this.lines, line]) mesh.frustumCulled = false;
    this.world.add(...this.paper, mark, this.lines, line, dot);
  }

  setTarget(found: Packed): void {
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(new Float32Array(bytes(found.vertices)), 3));
    geometry.setIndex(new BufferAttribute(new Uint32Array(bytes(found.faces)), 1));
    geometry.computeVertexNormals();
    const look = { color: TARGET, transparent: true, opacity: 0.32, side: DoubleSide, depthWrite: false };
    this.target?.removeFromParent();
    this.target = new Mesh(geometry, new MeshLambertMaterial(look));
    this.target.renderOrder = 1;
    this.world.add(this.target);
    this.seen = null;
  }

  // Everything that is ever shown, in the camera's frame: to the right, up, towards the viewer.
  #seen(): { points: Vector3[]; box: Box3 } {
    const points = this.motion.states.flatMap(({ coords }) =>
      this.data.vertices.map((_, k) => new Vector3().fromArray(coords, 3 * k)),
    );
    if (this.target) {
      const position = this.target.geometry.getAttribute("position");
      for (let k = 0; k < position.count; k += 1) points.push(new Vector3().fromBufferAttribute(position, k));
    }
    const turn = new Matrix4().makeBasis(RIGHT, UP, TOWARDS).transpose().multiply(this.world.matrix);
    for (const point of points) point.applyMatrix4(turn);
    return { points, box: new Box3().setFromPoints(points) };
  }

  // From the usual side, as near as all of it can be seen.
  #home(): void {
    this.seen ??= this.#seen();
    const { points, box } = this.seen;
    if (!points.length) return;
    const middle = box.getCenter(new Vector3());
    const radius = box.getSize(new Vector3()).length() / 2;
    const high = 0.93 * Math.tan((FIELD * Math.PI) / 360);
    const wide = high * this.camera.aspect;
    const distance = points.reduce((most, { x, y, z }) => {
      const needed = Math.max(Math.abs(x - middle.x) / wide, Math.abs(y - middle.y) / high);
      return Math.max(most, needed + z - middle.z);
    }, radius * 0.1);
    const centre = new Vector3()
      .addScaledVector(RIGHT, middle.x)
      .addScaledVector(UP, middle.y)
      .addScaledVector(TOWARDS, middle.z);
    for (const dot of [this.marks.vertex, ...this.pins]) dot.scale.setScalar(distance * 0.006);
    this.dotSize = distance * 0.006;
    this.camera.near = distance / 100;
    this.camera.far = distance * 20;
    this.camera.position.copy(centre).addScaledVector(TOWARDS, distance);
    this.camera.updateProjectionMatrix();
    this.controls.target.copy(centre);
    this.controls.minDistance = radius * 0.2;
    this.controls.maxDistance = distance * 6;
    this.moved = false;
    this.controls.update();
  }

  home(): void {
    this.#home();
    this.draw();
  }

  #resize(): void {
    const { clientWidth: width, clientHeight: height } = this.host;
    if (!width || !height) return;
    this.renderer.setSize(width, height);
    (this.lines.material as LineMaterial).linewidth = Math.min(2, Math.max(1, Math.min(width, height) / 220)); // pixels
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    if (!this.moved) this.#home();
    this.render(); // at once: a canvas that was resized is empty
  }

  show(state: SheetState): void {
    this.state = state;
    this.positions.array.set(state.coords);
    this.positions.needsUpdate = true;
    this.paper[0].geometry.computeBoundingSphere(); // the raycaster asks for it
    const at = (v: number) => state.coords.slice(3 * v, 3 * v + 3);
    // creases lie on lit paper in both themes, the boundary and what does not fold on the page's background, too
    const style = getComputedStyle(document.documentElement);
    const [ink, faint] = ["--ink", "--faint"].map((name) => new Color(style.getPropertyValue(name).trim()));
    const colours: Record<string, Color> = { M: MOUNTAIN, V: VALLEY, B: ink, C: ink, F: faint, J: faint, U: faint };
    const { edges } = this.data;
    const paint = edges.flatMap((_, k) => {
      const { r, g, b } = colours[this.motion.letter(state, k)];
      return [r, g, b, r, g, b];
    });
    const geometry = this.lines.geometry;
    geometry.setPositions(edges.flatMap(([u, v]) => [...at(u), ...at(v)]));
    geometry.setColors(paint);
    this.#showAddition(state.at);
    this.highlight(this.picked);
  }

  // What would be added to the sheet; null for nothing.
  showAddition(added: Addition | null): void {
    this.added = added;
    this.#showAddition(this.state?.at ?? 0);
    this.draw();
  }

  #showAddition(at: number): void {
    this.addition.visible = this.added !== null && this.added.angles.length > 0;
    if (!this.added || !this.addition.visible) return;
    const { angles, coords, triangles } = this.added;
    const nearest = angles.reduce((best, angle, k) => (Math.abs(angle - at) < Math.abs(angles[best] - at) ? k : best), 0);
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(new Float32Array(coords[nearest]), 3));
    geometry.setIndex(triangles.flat());
    this.addition.geometry.dispose();
    this.addition.geometry = geometry;
  }

  // Panels that pass through each other.
  showMeeting(panels: number[]): void {
    const { triangles, owners } = this.data;
    this.meeting.geometry.setIndex(triangles.filter((_, k) => panels.includes(owners[k])).flat());
    this.meeting.visible = panels.length > 0;
    this.draw();
  }

  // Dots at places in space.
  showPins(places: number[][]): void {
    for (const pin of this.pins.splice(0)) pin.removeFromParent();
    for (const place of places) {
      const pin = new Mesh(new SphereGeometry(1, 24, 16), new MeshBasicMaterial({ color: PIN, depthTest: false }));
      pin.renderOrder = 3;
      pin.position.fromArray(place);
      pin.scale.setScalar(1.6 * this.dotSize);
      this.pins.push(pin);
      this.world.add(pin);
    }
    this.draw();
  }

  showTarget(shown: boolean): void {
    if (this.target) this.target.visible = shown;
    this.draw();
  }

  highlight(picked: Picked | null): void {
    this.picked = picked;
    for (const [kind, mark] of Object.entries(this.marks)) mark.visible = picked !== null && picked.kind === kind;
    if (picked && this.state) {
      const { coords } = this.state;
      const at = (v: number) => coords.slice(3 * v, 3 * v + 3);
      const { edges, triangles, owners } = this.data;
      const { index } = picked;
      if (picked.kind === "panel") {
        this.marks.panel.geometry.setIndex(triangles.filter((_, k) => owners[k] === index).flat());
      } else if (picked.kind === "edge") {
        this.marks.edge.geometry.setPositions(edges[picked.index].flatMap(at));
      } else {
        this.marks.vertex.position.fromArray(at(picked.index));
      }
    }
    this.draw();
  }

  #listen(onPick: OnPick): void {
    const canvas = this.renderer.domElement;
    this.controls.addEventListener("start", () => {
      this.moved = true;
      this.turning = true;
    });
    this.controls.addEventListener("end", () => {
      this.turning = false;
    });
    canvas.addEventListener("pointermove", (event) => {
      if (event.pointerType === "mouse" && !this.turning) onPick(this.#pick(event));
    });
    canvas.addEventListener("pointerdown", (event) => {
      this.down = [event.clientX, event.clientY];
    });
    canvas.addEventListener("pointerup", (event) => {
      const [x, y] = this.down;
      if (Math.hypot(event.clientX - x, event.clientY - y) < 6) onPick(this.#pick(event)); // a tap, not a turn
    });
    canvas.addEventListener("pointerleave", (event) => {
      if (event.pointerType === "mouse") onPick(null);
    });
  }

  // What is under the pointer: of the panel that is hit a corner or a side, if one is near, else the panel.
  #pick(event: PointerEvent): Picked | null {
    const frame = this.renderer.domElement.getBoundingClientRect();
    const pointer = new Vector2(event.clientX - frame.left, event.clientY - frame.top);
    const device = new Vector2((pointer.x / frame.width) * 2 - 1, 1 - (pointer.y / frame.height) * 2);
    const ray = new Raycaster();
    ray.setFromCamera(device, this.camera);
    const { state } = this;
    const [hit] = ray.intersectObjects(this.paper, false);
    if (!hit || !state || hit.faceIndex == null) return null;
    const index = this.data.owners[hit.faceIndex];
    const panel = this.data.panels[index];
    const screen = (v: number) => {
      const point = new Vector3().fromArray(state.coords, 3 * v).applyMatrix4(this.world.matrix);
      point.project(this.camera);
      return new Vector2(((point.x + 1) / 2) * frame.width, ((1 - point.y) / 2) * frame.height);
    };
    const corner = panel.find((v) => screen(v).distanceTo(pointer) < NEAR_VERTEX);
    if (corner !== undefined) return { kind: "vertex", index: corner };
    const edge = this.data.sides[index].find((e) => {
      const [a, b] = this.data.edges[e].map(screen);
      const along = b.clone().sub(a);
      const part = Math.min(1, Math.max(0, pointer.clone().sub(a).dot(along) / along.lengthSq()));
      return a.addScaledVector(along, part).distanceTo(pointer) < NEAR_EDGE;
    });
    return edge === undefined ? { kind: "panel", index } : { kind: "edge", index: edge };
  }

  draw(): void {
    this.due ??= requestAnimationFrame(() => this.render());
  }

  render(): void {
    if (this.due !== undefined) cancelAnimationFrame(this.due);
    this.due = undefined;
    this.renderer.render(this.scene, this.camera);
  }
}
