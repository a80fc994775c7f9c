// Primitive shapes for links whose URDF has none: rods to what a link carries, with the girth of its mass, a hub where
// rotors are, a box of the link's inertia where nothing else shows it.

import * as THREE from "three";
import type { URDFLink, URDFRobot } from "urdf-loader";

/** Mean density of a limb, kg/m³. */
const DENSITY = 1000;
const ACCENT = 0x2f6fb0;

export const PALETTE = {
  body: new THREE.MeshStandardMaterial({ color: 0x46515e, roughness: 0.55, metalness: 0.15 }),
  limb: new THREE.MeshStandardMaterial({ color: 0xb9c2cc, roughness: 0.5, metalness: 0.1 }),
  joint: new THREE.MeshStandardMaterial({ color: ACCENT, roughness: 0.45, metalness: 0.1 }),
  tip: new THREE.MeshStandardMaterial({ color: 0x20262d, roughness: 0.7 }),
  disc: new THREE.MeshStandardMaterial({
    color: 0x7f93a8,
    transparent: true,
    opacity: 0.28,
    side: THREE.DoubleSide,
    depthWrite: false,
  }),
};

interface Mass {
  mass: number;
  centre: THREE.Vector3;
  /** Sides of the box with this inertia, and its orientation. */
  sides: THREE.Vector3;
}

function numbers(text: string | null | undefined): number[] {
  return (text ?? "").trim().split(/\s+/).map(Number);
}

function massOf(link: URDFLink): Mass | null {
  const node = link.urdfNode?.querySelector(":scope > inertial");
  const mass = Number(node?.querySelector("mass")?.getAttribute("value") ?? 0);
  if (!node || !(mass > 0)) return null;
  const at = numbers(node.querySelector("origin")?.getAttribute("xyz") ?? "0 0 0");
  const inertia = node.querySelector("inertia");
  const moment = (key: string) => Number(inertia?.getAttribute(key) ?? 0);
  const [x, y, z] = [moment("ixx"), moment("iyy"), moment("izz")];
  const side = (sum: number) => Math.sqrt(Math.max(0, (6 * sum) / mass));
  const sides = new THREE.Vector3(side(y + z - x), side(x + z - y), side(x + y - z));
  return { mass, centre: new THREE.Vector3(at[0] || 0, at[1] || 0, at[2] || 0), sides };
}

function rod(from: THREE.Vector3, to: THREE.Vector3, radius: number, material: THREE.Material): THREE.Mesh {
  const along = to.clone().sub(from);
  const length = along.length();
  const mesh = new THREE.Mesh(new THREE.CapsuleGeometry(radius, length, 6, 16), material);
  mesh.position.copy(from).addScaledVector(along, 0.5);
  mesh.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), along.normalize());
  return mesh;
}

function add(link: URDFLink, mesh: THREE.Mesh, shadow = true): void {
  mesh.castShadow = shadow;
  mesh.receiveShadow = shadow;
  mesh.userData.link = link.name;
  link.add(mesh);
}

function ball(radius: number, material: THREE.Material): THREE.Mesh {
  return new THREE.Mesh(new THREE.SphereGeometry(radius, 20, 14), material);
}

/** Whether the URDF itself draws this link. */
function isDrawn(link: URDFLink): boolean {
  return link.urdfNode?.querySelector(":scope > visual") != null;
}

/** Draws what the URDF does not. `rotors` are the names of links that carry a rotor. */
export function dress(robot: URDFRobot, rotors: Set<string>): void {
  const joints = Object.values(robot.joints);
  for (const link of Object.values(robot.links)) {
    if (isDrawn(link)) continue;
    const mass = massOf(link);
    const children = joints.filter((joint) => joint.parent === link);
    const carried = children.map((joint) => ({
      at: joint.position.clone(),
      moves: joint.jointType !== "fixed",
      link: joint.children.find((child) => (child as URDFLink).isURDFLink) as URDFLink | undefined,
    }));
    const arms = carried.filter(({ link }) => link && rotors.has(link.name));
    const limbs = carried.filter(({ at, link }) => at.length() > 0.02 && !(link && rotors.has(link.name)));
    if (rotors.has(link.name)) {
      rotor(link, robot);
      continue;
    }
    if (arms.length > 0)
      hub(
        link,
        arms.map(({ at }) => at),
      );
    if (!mass) {
      // A frame: what touches the world.
      if (children.length === 0) add(link, ball(0.012, PALETTE.tip));
      continue;
    }
    const flat = limbs.length === 1 && isAcross(mass.sides, limbs[0].at);
    const moved = joints.some((joint) => joint.jointType !== "fixed" && joint.children.includes(link));
    const reach = Math.max(0, ...limbs.map(({ at }) => at.length()));
    if (arms.length === 0 && (limbs.length > 1 || (limbs.length === 0 && mass.sides.length() > 0.03))) {
      torso(link, mass, limbs.length > 1 ? limbs.map(({ at }) => at) : []);
    } else if (arms.length === 0 && flat) {
      torso(link, mass, []);
    } else {
      for (const { at, moves } of limbs) {
        const volume = mass.mass / DENSITY / Math.max(1, limbs.length);
        const girth = Math.sqrt(volume / (Math.PI * at.length()));
        const radius = THREE.MathUtils.clamp(girth, 0.008, 0.3 * at.length());
        const thin = arms.length > 0 ? Math.min(radius, 0.018) : radius;
        add(link, rod(new THREE.Vector3(), at, thin, PALETTE.limb));
        if (moves) {
          const knuckle = ball(thin * 1.25, PALETTE.joint);
          knuckle.position.copy(at);
          add(link, knuckle);
        }
      }
    }
    if (moved && limbs.length === 0 && mass.centre.length() > 0.08) {
      // A head on its neck.
      add(link, rod(new THREE.Vector3(), mass.centre, 0.22 * Math.min(mass.sides.x, mass.sides.y), PALETTE.limb));
    }
    if (moved && reach === 0 && arms.length === 0 && limbs.length === 0) {
      const size = THREE.MathUtils.clamp(0.25 * mass.sides.length(), 0.008, 0.05);
      add(link, ball(size, PALETTE.joint));
    }
  }
}

/** Whether a link is longest across the way to what it carries: a foot, not a shank. */
function isAcross(sides: THREE.Vector3, way: THREE.Vector3): boolean {
  const axes = ["x", "y", "z"] as const;
  const long = axes.reduce((a, b) => (sides[b] > sides[a] ? b : a));
  const main = axes.reduce((a, b) => (Math.abs(way[b]) > Math.abs(way[a]) ? b : a));
  return long !== main && sides[long] > 1.5 * sides[main];
}

/** A box of the link's inertia, or around what it carries. */
function torso(link: URDFLink, mass: Mass, around: THREE.Vector3[]): void {
  // From its own joint on.
  const box = new THREE.Box3(new THREE.Vector3(), new THREE.Vector3());
  for (const at of around) box.expandByPoint(at);
  const sides = mass.sides
    .clone()
    .multiplyScalar(around.length > 2 ? 1 : 0.8)
    .clampScalar(0.02, 0.6);
  const centre = mass.centre.clone();
  if (around.length > 2) {
    const size = box.getSize(new THREE.Vector3());
    // As wide as what it carries, as thick as its mass.
    for (const axis of ["x", "y", "z"] as const) sides[axis] = Math.max(0.9 * size[axis], 0.45 * sides[axis], 0.03);
    box.getCenter(centre);
  }
  const radius = 0.3 * Math.min(sides.x, sides.y, sides.z);
  const shape = new THREE.Mesh(rounded(sides, radius), PALETTE.body);
  shape.position.copy(centre);
  add(link, shape);
}

/** A box with round edges along its longest axis. */
function rounded(sides: THREE.Vector3, radius: number): THREE.BufferGeometry {
  const shape = new THREE.Shape();
  const [w, h] = [sides.x / 2 - radius, sides.y / 2 - radius];
  shape.absarc(w, h, radius, 0, Math.PI / 2, false);
  shape.absarc(-w, h, radius, Math.PI / 2, Math.PI, false);
  shape.absarc(-w, -h, radius, Math.PI, 1.5 * Math.PI, false);
  shape.absarc(w, -h, radius, 1.5 * Math.PI, 2 * Math.PI, false);
  const bevel = 0.6 * radius;
  const depth = Math.max(1e-3, sides.z - 2 * bevel);
  const geometry = new THREE.ExtrudeGeometry(shape, {
    depth,
    bevelEnabled: true,
    bevelSize: 0,
    bevelThickness: bevel,
    bevelSegments: 3,
    curveSegments: 6,
  });
  geometry.translate(0, 0, -depth / 2);
  return geometry;
}

/** The body of a multirotor: a hub with a tube to every rotor. */
function hub(link: URDFLink, arms: THREE.Vector3[]): void {
  const mean = arms.reduce((sum, at) => sum + Math.hypot(at.x, at.y), 0) / arms.length;
  const height = arms.reduce((sum, at) => sum + at.z, 0) / arms.length;
  const centre = new THREE.Vector3(0, 0, height);
  const plate = new THREE.Mesh(new THREE.CylinderGeometry(0.34 * mean, 0.3 * mean, 0.16 * mean, 6), PALETTE.body);
  plate.rotation.x = Math.PI / 2;
  plate.position.copy(centre);
  add(link, plate);
  for (const at of arms) add(link, rod(centre, at, 0.024 * mean, PALETTE.limb));
}

/** A rotor: motor and disc in the plane across its thrust. */
function rotor(link: URDFLink, robot: URDFRobot): void {
  const places = Object.values(robot.joints)
    .filter((joint) => joint.children.includes(link))
    .map((joint) => Math.hypot(joint.position.x, joint.position.y));
  const size = THREE.MathUtils.clamp(0.33 * (places[0] || 0.4), 0.05, 0.3);
  const motor = new THREE.Mesh(new THREE.CylinderGeometry(0.16 * size, 0.18 * size, 0.22 * size, 20), PALETTE.tip);
  motor.rotation.x = Math.PI / 2;
  add(link, motor);
  const disc = new THREE.Mesh(new THREE.CylinderGeometry(size, size, 0.004, 40), PALETTE.disc);
  disc.rotation.x = Math.PI / 2;
  disc.position.z = 0.13 * size;
  add(link, disc, false);
}
