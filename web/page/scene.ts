// The robot and its world in 3-D: links, rotors with their thrusts, contacts with forces and cones, references, walls.

import * as THREE from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import URDFLoader, { type URDFRobot } from "urdf-loader";
import { dress } from "./dress";
import type { About, Contact, Field } from "./protocol";

export const COLOURS = {
  planned: "#2563c9",
  measured: "#d9730d",
  true: "#1f8a4c",
  reference: "#8a3ffc",
  limit: "#c4314b",
  thrust: "#2563c9",
} as const;

/** Points of a trace. */
const TRACE = 1500;

/** An arrow that can be made longer and shorter without new geometry. */
class Arrow extends THREE.Group {
  private readonly shaft: THREE.Mesh;
  private readonly head: THREE.Mesh;
  private readonly material: THREE.MeshBasicMaterial;

  /** `isOnTop`: seen through whatever is before it. */
  constructor(
    colour: THREE.ColorRepresentation,
    private readonly radius: number,
    isOnTop: boolean,
  ) {
    super();
    this.material = new THREE.MeshBasicMaterial({ color: colour, depthTest: !isOnTop, transparent: isOnTop });
    const shaft = new THREE.CylinderGeometry(radius, radius, 1, 12).translate(0, 0.5, 0);
    const head = new THREE.ConeGeometry(2.6 * radius, 6 * radius, 16).translate(0, 3 * radius, 0);
    this.shaft = new THREE.Mesh(shaft, this.material);
    this.head = new THREE.Mesh(head, this.material);
    this.shaft.renderOrder = this.head.renderOrder = isOnTop ? 10 : 0;
    this.add(this.shaft, this.head);
  }

  /** From a point along a vector; hidden if that is next to nothing. */
  point(from: THREE.Vector3, along: THREE.Vector3): void {
    const length = along.length();
    this.visible = length > 2 * this.radius;
    if (!this.visible) return;
    this.position.copy(from);
    this.quaternion.setFromUnitVectors(UP, along.clone().divideScalar(length));
    const tip = Math.min(6 * this.radius, 0.6 * length);
    this.shaft.scale.set(1, Math.max(1e-4, length - tip), 1);
    this.head.position.y = length - tip;
    this.head.scale.setScalar(tip / (6 * this.radius));
  }

  colour(colour: THREE.ColorRepresentation): void {
    this.material.color.set(colour);
  }
}

const UP = new THREE.Vector3(0, 1, 0);

/** The last places of a point, as a line. */
class Trace extends THREE.Line {
  private held = 0;

  constructor(colour: THREE.ColorRepresentation, opacity: number) {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(3 * TRACE), 3));
    geometry.setDrawRange(0, 0);
    super(geometry, new THREE.LineBasicMaterial({ color: colour, transparent: true, opacity }));
    this.frustumCulled = false;
  }

  push(at: THREE.Vector3): void {
    const places = this.geometry.getAttribute("position") as THREE.BufferAttribute;
    if (this.held > 0) {
      const last = 3 * (this.held - 1);
      const [x, y, z] = [0, 1, 2].map((i) => places.array[last + i]);
      if (Math.hypot(x - at.x, y - at.y, z - at.z) < 5e-4) return;
    }
    if (this.held === TRACE) {
      (places.array as Float32Array).copyWithin(0, 3 * (TRACE / 2));
      this.held = TRACE / 2;
    }
    places.setXYZ(this.held++, at.x, at.y, at.z);
    places.needsUpdate = true;
    this.geometry.setDrawRange(0, this.held);
  }

  clear(): this {
    this.held = 0;
    this.geometry.setDrawRange(0, 0);
    return this;
  }
}

interface DrawnContact {
  about: Contact;
  planned: Arrow;
  measured: Arrow;
  true: Arrow;
  cone: THREE.Group;
  trace: Trace;
}

interface DrawnRotor {
  index: number;
  link: THREE.Object3D;
  arrow: Arrow;
  bar: THREE.Group;
  lower: number;
  upper: number;
}

interface DrawnReference {
  name: string;
  marker: THREE.Object3D;
  trace: Trace;
  place: (values: ArrayLike<number>, out: THREE.Vector3) => void;
}

/** What somebody does with the pointer. */
export interface Hands {
  pull(frame: string, point: number[], force: number[]): void;
  wall(name: string, point: number[]): void;
}

export interface Meshes {
  /** A dropped file by its name. */
  find(name: string): File | null;
}

export class Scene {
  readonly canvas: HTMLCanvasElement;
  private readonly renderer: THREE.WebGLRenderer;
  private readonly scene = new THREE.Scene();
  private readonly camera = new THREE.PerspectiveCamera(38, 1, 0.02, 60);
  private readonly controls: OrbitControls;
  private readonly light: THREE.DirectionalLight;
  private robot: URDFRobot | null = null;
  private readonly world = new THREE.Group();
  private about: About | null = null;
  private fields = new Map<string, Field>();
  private contacts: DrawnContact[] = [];
  private rotors: DrawnRotor[] = [];
  private references: DrawnReference[] = [];
  private walls = new Map<string, THREE.Group>();
  private baseTrace = new Trace(0x5b6672, 0.7);
  private forceScale = 0.05;
  private thrustScale = 0.035;
  private frame: Float64Array | null = null;
  private readonly rubber: THREE.Line;
  private drag: Drag | null = null;
  private time = 0;
  private stale = true;
  private isBuilt = false;
  /** Whether the camera stays where it is. */
  private isKept = false;

  constructor(
    private readonly host: HTMLElement,
    private readonly hands: Hands,
    private readonly meshes: Meshes,
  ) {
    this.renderer = new THREE.WebGLRenderer({ antialias: true, preserveDrawingBuffer: true });
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = THREE.PCFShadowMap;
    this.canvas = this.renderer.domElement;
    this.canvas.tabIndex = 0;
    this.canvas.setAttribute("role", "img");
    this.canvas.setAttribute(
      "aria-label",
      "Robot in 3-D. Drag the robot to pull at it, a wall to move it, anything else to turn the view. " +
        "Arrow keys push the robot's base.",
    );
    host.append(this.canvas);
    this.scene.background = new THREE.Color(0xf3f5f7);
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, this.canvas);
    this.controls.enableDamping = true;
    this.controls.addEventListener("change", () => (this.stale = true));
    this.scene.add(new THREE.HemisphereLight(0xffffff, 0xb4bcc6, 1.9));
    this.light = new THREE.DirectionalLight(0xffffff, 2.0);
    this.light.position.set(-2.2, -2.8, 4.5);
    this.light.castShadow = true;
    this.light.shadow.mapSize.set(1024, 1024);
    const box = this.light.shadow.camera;
    [box.left, box.right, box.top, box.bottom, box.far] = [-2, 2, 2, -2, 12];
    this.light.shadow.bias = -5e-4;
    this.scene.add(this.light, this.light.target, this.world);
    const floor = new THREE.Mesh(new THREE.PlaneGeometry(40, 40), new THREE.ShadowMaterial({ opacity: 0.16 }));
    floor.receiveShadow = true;
    const grid = new THREE.GridHelper(20, 40, 0xb8c1cb, 0xdde2e7);
    grid.rotation.x = Math.PI / 2;
    grid.position.z = -1e-3;
    this.scene.add(floor, grid);
    this.rubber = new THREE.Line(
      new THREE.BufferGeometry().setFromPoints([new THREE.Vector3(), new THREE.Vector3()]),
      new THREE.LineBasicMaterial({ color: COLOURS.limit }),
    );
    this.rubber.frustumCulled = false;
    this.rubber.visible = false;
    this.scene.add(this.rubber);
    this.listen();
    new ResizeObserver(() => this.resize()).observe(host);
    this.resize();
    const draw = () => {
      requestAnimationFrame(draw);
      this.controls.update();
      if (!this.stale) return;
      this.stale = false;
      this.renderer.render(this.scene, this.camera);
    };
    draw();
  }

  private resize(): void {
    const { clientWidth, clientHeight } = this.host;
    if (clientWidth === 0 || clientHeight === 0) return;
    this.renderer.setSize(clientWidth, clientHeight);
    this.camera.aspect = clientWidth / clientHeight;
    // On a narrow screen the same width must be seen.
    this.camera.fov = this.camera.aspect < 1 ? 52 : 38;
    this.camera.updateProjectionMatrix();
    this.stale = true;
  }

  /** A robot and its world; what was drawn before is gone. */
  load(about: About, fields: Field[]): void {
    const same = this.about?.urdf === about.urdf && this.about?.scenario === about.scenario;
    this.about = about;
    this.fields = new Map(fields.map((field) => [field.name, field]));
    this.release();
    this.world.clear();
    this.contacts = [];
    this.rotors = [];
    this.references = [];
    this.walls.clear();
    this.frame = null;
    this.isBuilt = false;
    this.robot = this.parse(about);
    if (this.robot) this.world.add(this.robot);
    const bears = Math.max(1, about.contacts.length);
    this.forceScale = about.actuators.some((a) => a.rotor)
      ? 0.055
      : (0.45 * this.size()) / ((about.mass * 9.81) / bears);
    this.baseTrace = new Trace(0x5b6672, 0.6);
    this.world.add(this.baseTrace);
    for (const wall of about.walls) this.addWall(wall);
    for (const contact of about.contacts) this.addContact(contact);
    about.actuators.forEach((actuator, index) => {
      const link = actuator.rotor ? this.robot?.links[actuator.rotor] : undefined;
      if (link && actuator.lower !== null && actuator.upper !== null) {
        this.addRotor(index, link, actuator.lower, actuator.upper);
      }
    });
    for (const entry of about.entries) this.addReference(entry.name, entry.type, entry.error_unit, entry);
    this.isKept = same;
    this.stale = true;
  }

  private parse(about: About): URDFRobot | null {
    if (!about.urdf) return null;
    const loader = new URDFLoader();
    // Meshes come from what was dropped with the URDF; what is not there is drawn as a primitive.
    loader.packages = "";
    const rest = loader.loadMeshCb;
    loader.loadMeshCb = (path, manager, material, done) => {
      const name = path.split(/[\\/]/).pop() ?? path;
      const file = this.meshes.find(name);
      if (!file) {
        done(new THREE.Group());
        return;
      }
      // The extension says what it is.
      const url = URL.createObjectURL(file) + "#" + name;
      rest(url, manager, material, (mesh, error) => {
        URL.revokeObjectURL(url.split("#")[0]);
        mesh?.traverse((part) => (part.castShadow = true));
        done(mesh ?? new THREE.Group(), error);
        this.stale = true;
      });
    };
    let robot: URDFRobot;
    try {
      robot = loader.parse(about.urdf);
    } catch (error) {
      console.warn("the URDF cannot be drawn:", error);
      return null;
    }
    const rotors = new Set(about.actuators.flatMap((a) => (a.rotor ? [a.rotor] : [])));
    dress(robot, rotors);
    for (const link of Object.values(robot.links)) {
      link.traverse((part) => {
        part.userData.link ??= this.linkOf(part);
        if ((part as THREE.Mesh).isMesh) part.castShadow = true;
      });
    }
    return robot;
  }

  private linkOf(part: THREE.Object3D | null): string | null {
    for (let at = part; at; at = at.parent) {
      if ((at as { isURDFLink?: boolean }).isURDFLink) return at.name;
    }
    return null;
  }

  /** Greatest extent of the robot, m. */
  private size(): number {
    if (!this.robot) return 1;
    const box = new THREE.Box3().setFromObject(this.robot);
    const size = box.getSize(new THREE.Vector3());
    return Math.max(0.2, size.x, size.y, size.z);
  }

  private addWall(wall: { name: string; point: number[]; normal: number[] }): void {
    const normal = new THREE.Vector3(...(wall.normal as [number, number, number])).normalize();
    const group = new THREE.Group();
    group.name = wall.name;
    group.userData.normal = normal;
    if (normal.z < 0.9) {
      const panel = new THREE.Mesh(
        new THREE.BoxGeometry(1.8, 1, 0.02).translate(0, 0.5, -0.01),
        new THREE.MeshStandardMaterial({ color: 0xcdb894, roughness: 0.9, transparent: true, opacity: 0.55 }),
      );
      panel.receiveShadow = true;
      panel.userData.wall = wall.name;
      const edges = new THREE.LineSegments(
        new THREE.EdgesGeometry(panel.geometry),
        new THREE.LineBasicMaterial({ color: 0x8a7550 }),
      );
      panel.add(edges);
      // Upright, its long side level.
      const level = new THREE.Vector3(0, 0, 1).cross(normal);
      const upright = new THREE.Matrix4().makeBasis(level, normal.clone().cross(level), normal);
      panel.quaternion.setFromRotationMatrix(upright);
      group.add(panel);
    }
    this.walls.set(wall.name, group);
    this.world.add(group);
  }

  private addContact(about: Contact): void {
    const radius = 0.006 * Math.max(0.6, Math.min(2, this.size()));
    const [planned, measured, real] = (["planned", "measured", "true"] as const).map(
      (which, i) => new Arrow(COLOURS[which], radius * [1.5, 1.2, 0.9][i], true),
    );
    const cone = new THREE.Group();
    const height = 0.16 * Math.max(0.6, Math.min(2.5, this.size()));
    const base = height * Math.min(about.friction, 2);
    const shape = new THREE.ConeGeometry(base, height, 32, 1, true).rotateX(Math.PI).translate(0, height / 2, 0);
    const skin = new THREE.Mesh(
      shape,
      new THREE.MeshBasicMaterial({
        color: 0xe0a100,
        transparent: true,
        opacity: 0.2,
        side: THREE.DoubleSide,
        depthWrite: false,
      }),
    );
    const ring = new THREE.LineLoop(
      new THREE.BufferGeometry().setFromPoints(
        Array.from({ length: 48 }, (_, i) => {
          const a = (i / 48) * 2 * Math.PI;
          return new THREE.Vector3(base * Math.cos(a), height, base * Math.sin(a));
        }),
      ),
      new THREE.LineBasicMaterial({ color: 0xb88400 }),
    );
    cone.add(skin, ring);
    const trace = new Trace(0x1f8a4c, 0.7);
    this.world.add(planned, measured, real, cone, trace);
    this.contacts.push({ about, planned, measured, true: real, cone, trace });
  }

  private addRotor(index: number, link: THREE.Object3D, lower: number, upper: number): void {
    const arrow = new Arrow(COLOURS.thrust, 0.008, false);
    const bar = new THREE.Group();
    const colour = new THREE.MeshBasicMaterial({ color: 0x98a4b1 });
    const long = (upper - lower) * this.thrustScale;
    const line = new THREE.Mesh(
      new THREE.CylinderGeometry(0.0018, 0.0018, long, 6).translate(0, lower * this.thrustScale + long / 2, 0),
      colour,
    );
    bar.add(line);
    for (const limit of [lower, upper]) {
      const ring = new THREE.Mesh(new THREE.TorusGeometry(0.02, 0.0028, 6, 24).rotateX(Math.PI / 2), colour);
      ring.position.y = limit * this.thrustScale;
      bar.add(ring);
    }
    this.world.add(arrow, bar);
    this.rotors.push({ index, link, arrow, bar, lower, upper });
  }

  private addReference(
    name: string,
    type: string,
    unit: string | undefined,
    entry: { parameters: Record<string, unknown>; reference?: { space: string; value: number[] } | null },
  ): void {
    const reference = entry.reference;
    if (reference?.space !== "vector" || unit !== "m" || !this.fields.has(`reference/${name}`)) return;
    let place: DrawnReference["place"];
    if (reference.value.length === 3 && type !== "relative_pose") {
      place = (values, out) => out.set(values[0], values[1], values[2]);
    } else if (reference.value.length === 2) {
      // In the surface's own coordinates.
      const contact = this.about?.contacts.find((c) => c.name === entry.parameters.contact);
      if (!contact) return;
      const [a, o] = [contact.axes, contact.origin];
      place = (values, out) =>
        out.set(
          o[0] + a[0] * values[0] + a[3] * values[1],
          o[1] + a[1] * values[0] + a[4] * values[1],
          o[2] + a[2] * values[0] + a[5] * values[1],
        );
    } else {
      return;
    }
    const marker = new THREE.Group();
    const arm = 0.05 * Math.max(0.7, Math.min(1.5, this.size()));
    for (const axis of [
      [1, 0, 0],
      [0, 1, 0],
      [0, 0, 1],
    ]) {
      const ends = [1, -1].map((s) => new THREE.Vector3(...(axis as [number, number, number])).multiplyScalar(s * arm));
      marker.add(
        new THREE.Line(
          new THREE.BufferGeometry().setFromPoints(ends),
          new THREE.LineBasicMaterial({ color: COLOURS.reference }),
        ),
      );
    }
    marker.add(
      new THREE.Mesh(
        new THREE.SphereGeometry(0.25 * arm, 16, 12),
        new THREE.MeshBasicMaterial({ color: COLOURS.reference }),
      ),
    );
    const trace = new Trace(COLOURS.reference, 0.9);
    this.world.add(marker, trace);
    this.references.push({ name, marker, trace, place });
  }

  /** Puts the camera where robot and wall are seen. */
  private look(): void {
    const flies = this.rotors.length > 0;
    if (flies) {
      const wall = this.about?.walls[0];
      const x = wall ? wall.point[0] - 0.32 : 0;
      this.controls.target.set(x + 0.1, 0, 1.06);
      this.camera.position.set(x - 1.2, -1.95, 1.72);
    } else {
      const sphere = new THREE.Box3().setFromObject(this.robot ?? this.world).getBoundingSphere(new THREE.Sphere());
      const far = 2.75 * Math.max(0.1, sphere.radius);
      this.controls.target.copy(sphere.center);
      this.camera.position.copy(sphere.center).add(new THREE.Vector3(0.58, -0.74, 0.36).multiplyScalar(far));
    }
    this.controls.update();
  }

  private take(frame: Float64Array, name: string): Float64Array | null {
    const field = this.fields.get(name);
    return field ? frame.subarray(field.at, field.at + field.count) : null;
  }

  /** Draws a state. */
  show(frame: Float64Array): void {
    this.frame = frame;
    this.stale = true;
    const time = this.take(frame, "time")?.[0] ?? 0;
    if (time < this.time) this.forget();
    this.time = time;
    const [p, Q, q] = ["position", "quaternion", "joints"].map((name) => this.take(frame, name));
    if (this.robot && p && Q && q && this.about) {
      this.robot.position.set(p[0], p[1], p[2]);
      this.robot.quaternion.set(Q[0], Q[1], Q[2], Q[3]);
      this.about.joints.forEach((joint, i) => this.robot?.setJointValue(joint.name, q[i]));
      this.robot.updateMatrixWorld(true);
      this.light.target.position.set(p[0], p[1], 0.5 * p[2]);
      this.light.position.set(p[0] - 2.2, p[1] - 2.8, p[2] + 3.5);
      this.baseTrace.push(this.robot.position);
    }
    if (!this.isBuilt) this.build(frame);
    for (const wall of this.walls.values()) {
      const at = this.take(frame, `wall/${wall.name}`);
      if (at) wall.position.set(at[0], at[1], at[2]);
    }
    const efforts = this.take(frame, "efforts");
    for (const rotor of this.rotors) {
      const thrust = efforts?.[rotor.index] ?? 0;
      const from = rotor.link.getWorldPosition(new THREE.Vector3());
      const turned = rotor.link.getWorldQuaternion(new THREE.Quaternion());
      const axis = new THREE.Vector3(0, 0, 1).applyQuaternion(turned);
      rotor.arrow.point(from, axis.clone().multiplyScalar(thrust * this.thrustScale));
      rotor.bar.position.copy(from);
      rotor.bar.quaternion.setFromUnitVectors(UP, axis);
      const near = 0.01 * (rotor.upper - rotor.lower);
      const bound = thrust - rotor.lower < near || rotor.upper - thrust < near;
      rotor.arrow.colour(bound ? COLOURS.limit : COLOURS.thrust);
    }
    for (const contact of this.contacts) this.showContact(contact, frame);
    for (const reference of this.references) {
      const values = this.take(frame, `reference/${reference.name}`);
      const alpha = this.take(frame, `task/${reference.name}/alpha`)?.[0] ?? 1;
      reference.marker.visible = alpha > 0;
      if (!values || alpha <= 0) continue;
      reference.place(values, reference.marker.position);
      reference.trace.push(reference.marker.position);
    }
    if (this.drag) this.pullOn();
  }

  /** Walls reach a hand's breadth above what touches them: the plant's are planes, but nothing above touches them. */
  private build(frame: Float64Array): void {
    this.isBuilt = true;
    const heights = this.contacts.map(({ about }) => this.take(frame, `contact/${about.name}/point`)?.[2] ?? 1);
    const top = heights.length > 0 ? Math.max(...heights) + 0.15 : 1;
    if (!this.isKept) this.look();
    for (const wall of this.walls.values()) for (const panel of wall.children) panel.scale.y = Math.max(0.3, top);
  }

  private showContact(contact: DrawnContact, frame: Float64Array): void {
    const name = contact.about.name;
    const at = this.take(frame, `contact/${name}/point`);
    const normal = this.take(frame, `contact/${name}/normal`);
    const on = this.take(frame, `contact/${name}/switch`);
    if (!at || !normal || !on) return;
    const point = new THREE.Vector3(at[0], at[1], at[2]);
    const n = new THREE.Vector3(normal[0], normal[1], normal[2]);
    contact.cone.visible = on[1] > 0;
    contact.cone.position.copy(point);
    contact.cone.quaternion.setFromUnitVectors(UP, n);
    // Side by side, so that equal forces are seen as three.
    const aside = new THREE.Vector3(0, 0, 1).cross(n);
    if (aside.length() < 0.1) aside.set(0, 1, 0);
    aside.normalize().multiplyScalar(0.016 * Math.max(0.7, Math.min(2, this.forceScale * 20)));
    (["planned", "measured", "true"] as const).forEach((which, i) => {
      const force = this.take(frame, `contact/${name}/${which}`);
      if (!force || (which === "measured" && contact.about.sensed === false)) {
        contact[which].visible = false;
        return;
      }
      const along = new THREE.Vector3(force[0], force[1], force[2]).multiplyScalar(this.forceScale);
      const limit = 1.2 * Math.max(0.5, this.size());
      contact[which].point(point.clone().addScaledVector(aside, i - 1), along.clampLength(0, limit));
    });
    if ((this.take(frame, `contact/${name}/true`) ?? []).some((f) => f !== 0)) contact.trace.push(point);
  }

  /** Traces begin anew. */
  forget(): void {
    this.baseTrace.clear();
    for (const { trace } of [...this.contacts, ...this.references]) trace.clear();
  }

  // What the pointer does.

  private listen(): void {
    this.canvas.addEventListener("pointerdown", (event) => this.grab(event), { capture: true });
    this.canvas.addEventListener("pointermove", (event) => this.move(event));
    for (const end of ["pointerup", "pointercancel"] as const) {
      this.canvas.addEventListener(end, () => this.release());
    }
    const push: Record<string, [number, number, number]> = {
      ArrowUp: [0, 0, 1],
      ArrowDown: [0, 0, -1],
      ArrowLeft: [-1, 0, 0],
      ArrowRight: [1, 0, 0],
    };
    this.canvas.addEventListener("keydown", (event) => {
      const along = push[event.key];
      if (!along || !this.about) return;
      event.preventDefault();
      const force = 0.12 * this.about.mass * 9.81;
      this.hands.pull(
        this.about.base,
        [0, 0, 0],
        along.map((a) => a * force),
      );
    });
    this.canvas.addEventListener("keyup", (event) => {
      if (push[event.key] && this.about) this.hands.pull(this.about.base, [0, 0, 0], [0, 0, 0]);
    });
  }

  private ray(event: PointerEvent): THREE.Raycaster {
    const box = this.canvas.getBoundingClientRect();
    const at = new THREE.Vector2(
      ((event.clientX - box.left) / box.width) * 2 - 1,
      1 - ((event.clientY - box.top) / box.height) * 2,
    );
    const ray = new THREE.Raycaster();
    ray.setFromCamera(at, this.camera);
    return ray;
  }

  private grab(event: PointerEvent): void {
    if (event.button !== 0 || !event.isPrimary) return;
    const ray = this.ray(event);
    const targets: THREE.Object3D[] = [...this.walls.values()];
    if (this.robot) targets.push(this.robot);
    const hits = ray.intersectObjects(targets, true).filter((hit) => (hit.object as THREE.Mesh).isMesh);
    // The robot before a wall that one sees through.
    const hit = hits.find((h) => h.object.userData.link) ?? hits.find((h) => h.object.userData.wall);
    if (!hit) return;
    const { link, wall } = hit.object.userData as { link?: string; wall?: string };
    const away = this.camera.getWorldDirection(new THREE.Vector3()).negate();
    if (link && this.robot) {
      const owner = this.robot.links[link];
      const local = owner.worldToLocal(hit.point.clone());
      this.drag = {
        kind: "link",
        link,
        local,
        plane: new THREE.Plane().setFromNormalAndCoplanarPoint(away, hit.point),
        target: hit.point.clone(),
      };
    } else if (wall) {
      const group = this.walls.get(wall);
      if (!group) return;
      this.drag = {
        kind: "wall",
        wall,
        start: group.position.clone(),
        from: hit.point.clone(),
        normal: group.userData.normal,
        last: 0,
      };
    }
    if (this.drag) {
      event.stopImmediatePropagation();
      this.controls.enabled = false;
      this.canvas.setPointerCapture(event.pointerId);
      this.canvas.style.cursor = "grabbing";
    }
  }

  private move(event: PointerEvent): void {
    if (!this.drag) {
      if (event.pointerType === "mouse" && event.buttons === 0) {
        const targets = this.robot ? [this.robot, ...this.walls.values()] : [...this.walls.values()];
        const over = this.ray(event).intersectObjects(targets, true).length > 0;
        this.canvas.style.cursor = over ? "grab" : "";
      }
      return;
    }
    const ray = this.ray(event).ray;
    if (this.drag.kind === "link") {
      ray.intersectPlane(this.drag.plane, this.drag.target);
      this.pullOn();
      return;
    }
    // Along the wall's normal, by the point of that line that is nearest to the pointer's.
    const { normal, from, start, wall } = this.drag;
    const w = from.clone().sub(ray.origin);
    const b = normal.dot(ray.direction);
    const along = (b * ray.direction.dot(w) - normal.dot(w)) / Math.max(1e-3, 1 - b * b);
    const want = THREE.MathUtils.clamp(along, -0.6, 0.6);
    // A wall that jumps throws the robot.
    const step = THREE.MathUtils.clamp(want - this.drag.last, -0.004, 0.004);
    this.drag.last += step;
    this.hands.wall(wall, start.clone().addScaledVector(normal, this.drag.last).toArray());
  }

  private pullOn(): void {
    if (this.drag?.kind !== "link" || !this.robot || !this.about) return;
    const { link, local, target } = this.drag;
    const at = this.robot.links[link].localToWorld(local.clone());
    const weight = this.about.mass * 9.81;
    // A spring between hand and link, of the robot's weight per half a metre.
    const force = target
      .clone()
      .sub(at)
      .multiplyScalar(2 * weight)
      .clampLength(0, 0.8 * weight);
    this.hands.pull(link, local.toArray(), force.toArray());
    const line = this.rubber.geometry.getAttribute("position") as THREE.BufferAttribute;
    line.setXYZ(0, at.x, at.y, at.z);
    line.setXYZ(1, target.x, target.y, target.z);
    line.needsUpdate = true;
    this.rubber.visible = true;
    this.stale = true;
  }

  private release(): void {
    if (this.drag?.kind === "link") this.hands.pull(this.drag.link, [0, 0, 0], [0, 0, 0]);
    this.drag = null;
    this.rubber.visible = false;
    this.controls.enabled = true;
    this.canvas.style.cursor = "";
    this.stale = true;
  }

  /** Where a link's origin or a wall's middle is on the canvas, in its pixels: for tests that drag it. */
  whereIs(name: string): [number, number] | null {
    const [link, wall] = [this.robot?.links[name], this.walls.get(name)];
    if (!this.frame || !(link ?? wall)) return null;
    const at = new THREE.Vector3();
    if (link) link.getWorldPosition(at);
    else if (wall) new THREE.Box3().setFromObject(wall).getCenter(at);
    at.project(this.camera);
    return [((at.x + 1) / 2) * this.canvas.clientWidth, ((1 - at.y) / 2) * this.canvas.clientHeight];
  }
}

type Drag =
  | { kind: "link"; link: string; local: THREE.Vector3; plane: THREE.Plane; target: THREE.Vector3 }
  | { kind: "wall"; wall: string; start: THREE.Vector3; from: THREE.Vector3; normal: THREE.Vector3; last: number };
