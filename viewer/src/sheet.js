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
  SphereGeometry,
  Vector2,
  Vector3,
  WebGLRenderer,
} from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { LineMaterial } from "three/addons/lines/LineMaterial.js";
import { LineSegments2 } from "three/addons/lines/LineSegments2.js";
import { LineSegmentsGeometry } from "three/addons/lines/LineSegmentsGeometry.js";

const FRONT = 0xf4a858;
const BACK = 0x709ac8;
const TARGET = 0x58be96;
const PICKED = 0xffe14d;
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

// Numbers in base64, little-endian.
function numbers(text, Kind) {
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  return new Kind(bytes.buffer);
}

export class Sheet {
  constructor(host, data, motion, onPick) {
    this.host = host;
    this.data = data;
    this.motion = motion;
    this.renderer = new WebGLRenderer({ antialias: true, alpha: true });
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    host.append(this.renderer.domElement);
    this.scene = new Scene();
    this.camera = new PerspectiveCamera(FIELD, 1, 0.1, 1000);
    this.camera.up.set(0, 0, 1);
    const lamp = new DirectionalLight(0xffffff, 2.1);
    lamp.position.set(-0.5, 0.9, 1.2); // beside the viewer, in the camera's frame
    this.camera.add(lamp);
    this.scene.add(this.camera, new AmbientLight(0xffffff, 1.5));
    this.world = new Group(); // turned as the sheet is used
    const [r, s, t] = data.upright;
    this.world.matrix = new Matrix4().set(...r, 0, ...s, 0, ...t, 0, 0, 0, 0, 1);
    this.world.matrixAutoUpdate = false;
    this.scene.add(this.world);
    this.#paper();
    if (data.target) this.#target(data.target);
    this.controls = new OrbitControls(this.camera, this.renderer.domElement);
    this.controls.addEventListener("change", () => this.draw());
    this.#home();
    new ResizeObserver(() => this.#resize()).observe(host);
    this.#listen(onPick);
    this.#resize();
  }

  #paper() {
    const { data } = this;
    this.positions = new BufferAttribute(new Float32Array(3 * data.vertices.length), 3);
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", this.positions);
    geometry.setIndex(data.triangles.flat());
    const offset = { polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 2 }; // behind its lines
    const side = (color, which) =>
      new Mesh(geometry, new MeshLambertMaterial({ color, side: which, flatShading: true, ...offset }));
    this.paper = [side(FRONT, FrontSide), side(BACK, BackSide)];
    this.mark = new Mesh(
      new BufferGeometry().setAttribute("position", this.positions),
      new MeshBasicMaterial({ color: PICKED, transparent: true, opacity: 0.55, side: DoubleSide, depthWrite: false }),
    );
    this.lines = new LineSegments2(
      new LineSegmentsGeometry(),
      new LineMaterial({ vertexColors: true }),
    );
    this.line = new LineSegments2(new LineSegmentsGeometry(), new LineMaterial({ linewidth: 5, color: PICKED }));
    this.dot = new Mesh(new SphereGeometry(1, 24, 16), new MeshBasicMaterial({ color: PICKED, depthTest: false }));
    this.dot.renderOrder = 2;
    this.marks = { panel: this.mark, edge: this.line, vertex: this.dot };
    for (const mark of Object.values(this.marks)) mark.visible = false;
    for (const mesh of [...this.paper, this.mark, this.lines, this.line]) mesh.frustumCulled = false;
    this.world.add(...this.paper, this.mark, this.lines, this.line, this.dot);
  }

  #target(found) {
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(numbers(found.vertices, Float32Array), 3));
    geometry.setIndex(new BufferAttribute(numbers(found.faces, Uint32Array), 1));
    geometry.computeVertexNormals();
    const look = { color: TARGET, transparent: true, opacity: 0.32, side: DoubleSide, depthWrite: false };
    this.target = new Mesh(geometry, new MeshLambertMaterial(look));
    this.target.renderOrder = 1;
    this.world.add(this.target);
  }

  // Everything that is ever shown, in the camera's frame: to the right, up, towards the viewer.
  #seen() {
    const points = this.motion.states.flatMap(({ coords }) =>
      this.data.vertices.map((_, k) => new Vector3().fromArray(coords, 3 * k)),
    );
    if (this.target) {
      const { position } = this.target.geometry.attributes;
      for (let k = 0; k < position.count; k += 1) points.push(new Vector3().fromBufferAttribute(position, k));
    }
    const turn = new Matrix4().makeBasis(RIGHT, UP, TOWARDS).transpose().multiply(this.world.matrix);
    for (const point of points) point.applyMatrix4(turn);
    return { points, box: new Box3().setFromPoints(points) };
  }

  // From the usual side, as near as all of it can be seen.
  #home() {
    this.seen ??= this.#seen();
    const { points, box } = this.seen;
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
    this.dot.scale.setScalar(distance * 0.006);
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

  home() {
    this.#home();
    this.draw();
  }

  #resize() {
    const { clientWidth: width, clientHeight: height } = this.host;
    if (!width || !height) return;
    this.renderer.setSize(width, height);
    this.lines.material.linewidth = Math.min(2, Math.max(1, Math.min(width, height) / 220)); // pixels
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    if (!this.moved) this.#home();
    this.render(); // at once: a canvas that was resized is empty
  }

  show(state) {
    this.state = state;
    this.positions.array.set(state.coords);
    this.positions.needsUpdate = true;
    this.paper[0].geometry.computeBoundingSphere(); // the raycaster asks for it
    const at = (v) => state.coords.slice(3 * v, 3 * v + 3);
    // creases lie on lit paper in both themes, the boundary and what does not fold on the page's background, too
    const style = getComputedStyle(document.documentElement);
    const [ink, faint] = ["--ink", "--faint"].map((name) => new Color(style.getPropertyValue(name).trim()));
    const colours = { M: MOUNTAIN, V: VALLEY, B: ink, C: ink, F: faint, J: faint, U: faint };
    const { edges } = this.data;
    const paint = edges.flatMap((_, k) => {
      const { r, g, b } = colours[this.motion.letter(state, k)];
      return [r, g, b, r, g, b];
    });
    this.lines.geometry.setPositions(edges.flatMap(([u, v]) => [...at(u), ...at(v)]));
    this.lines.geometry.setColors(paint);
    this.highlight(this.picked);
  }

  showTarget(shown) {
    if (this.target) this.target.visible = shown;
    this.draw();
  }

  highlight(picked) {
    this.picked = picked;
    for (const [kind, mark] of Object.entries(this.marks)) mark.visible = Boolean(picked) && picked.kind === kind;
    if (picked && this.state) {
      const at = (v) => this.state.coords.slice(3 * v, 3 * v + 3);
      const { edges, triangles, owners } = this.data;
      if (picked.kind === "panel") {
        this.mark.geometry.setIndex(triangles.filter((_, k) => owners[k] === picked.index).flat());
      } else if (picked.kind === "edge") {
        this.line.geometry.setPositions(edges[picked.index].flatMap(at));
      } else {
        this.dot.position.fromArray(at(picked.index));
      }
    }
    this.draw();
  }

  #listen(onPick) {
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
      const [x, y] = this.down ?? [Infinity, Infinity];
      if (Math.hypot(event.clientX - x, event.clientY - y) < 6) onPick(this.#pick(event)); // a tap, not a turn
    });
    canvas.addEventListener("pointerleave", (event) => event.pointerType === "mouse" && onPick(null));
  }

  // What is under the pointer: of the panel that is hit a corner or a side, if one is near, else the panel.
  #pick(event) {
    const frame = this.renderer.domElement.getBoundingClientRect();
    const pointer = new Vector2(event.clientX - frame.left, event.clientY - frame.top);
    const device = new Vector2((pointer.x / frame.width) * 2 - 1, 1 - (pointer.y / frame.height) * 2);
    const ray = new Raycaster();
    ray.setFromCamera(device, this.camera);
    const [hit] = ray.intersectObjects(this.paper, false);
    if (!hit) return null;
    const index = this.data.owners[hit.faceIndex];
    const panel = this.data.panels[index];
    const screen = (v) => {
      const point = new Vector3().fromArray(this.state.coords, 3 * v).applyMatrix4(this.world.matrix);
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

  draw() {
    this.due ??= requestAnimationFrame(() => this.render());
  }

  render() {
    if (this.due) cancelAnimationFrame(this.due);
    this.due = undefined;
    this.renderer.render(this.scene, this.camera);
  }
}
