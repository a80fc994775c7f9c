// What the page and its worker say to one another, and the shapes of what the module says as JSON.

export interface Shipped {
  name: string;
  title: string;
  about: string;
  case: string;
  path: string;
  text: string;
  controller: string;
}

export interface Field {
  name: string;
  at: number;
  count: number;
}

export interface Fields {
  frame: Field[];
  history: Field[];
}

export interface Actuator {
  name: string;
  /** The rotor's frame; nothing for a joint's motor. */
  rotor: string | null;
  lower: number | null;
  upper: number | null;
}

export interface Contact {
  name: string;
  frame: string;
  kind: string;
  friction: number;
  force_min?: number;
  force_max?: number;
  active?: boolean;
  /** Whether its force is measured. */
  sensed?: boolean;
  /** Rotation of the surface's axes, column by column. */
  axes: number[];
  origin: number[];
  [key: string]: unknown;
}

export interface Entry {
  kind: "task" | "constraint";
  name: string;
  type: string;
  weight: number | number[];
  active: boolean;
  hardness: unknown;
  parameters: Record<string, unknown>;
  rows?: { label: string; unit: string }[];
  error_unit?: string;
  reference?: { space: "vector" | "rotation"; value: number[] } | null;
}

export interface Wall {
  name: string;
  point: number[];
  normal: number[];
  friction: number;
}

export interface About {
  scenario: string;
  case: string;
  cases: string[];
  duration: number;
  rate: number;
  robot: string;
  base: string;
  mass: number;
  urdf: string | null;
  joints: { name: string; unit: string }[];
  actuators: Actuator[];
  contacts: Contact[];
  entries: Entry[];
  events: { at: number; mark: string | null }[];
  disturbances: { name: string; frame: string; force: number[]; from: number | null; until: number | null }[];
  walls: Wall[];
  diagnostics: string[];
}

export interface Words {
  time: number;
  level: "optimal" | "relaxed" | "extrapolated" | "safe";
  why: string | null;
  last: { at: number; why: string } | null;
  stopped: string | null;
  over: boolean;
}

/** What a weight or a gain does to a tick's optimum; slopes are by its logarithm. */
export interface Effect {
  kind: "weight" | "gain";
  owner: string;
  key: string;
  /** Of all efforts together. */
  effort: number;
  /** The outputs that move most: an effort, a force, an acceleration. */
  most: { name: string; slope: number; unit: string }[];
}

export interface Matters {
  /** Of the tick; nothing before there was one. */
  time: number | null;
  /** Why there are no derivatives. */
  refused: string | null;
  effects: Effect[];
  limits: { name: string; side: string }[];
  notes: string[];
}

export type Change =
  | { do: "set"; of: string; keys: Record<string, unknown> }
  | { do: "weight"; of: string; value: number | number[] }
  | { do: "follow"; of: string; reference: Record<string, unknown> }
  | { do: "entry"; of: string; on: boolean }
  | { do: "contact"; of: string; on: boolean }
  | { do: "tare"; of: string };

export interface Row {
  id: string;
  quantity: string;
  unit: string;
  paper: number | null;
  measured: number | null;
  tolerance: string;
  pass: boolean | null;
  promised: boolean;
}

// JSON Schema, as far as it is looked at.
export interface Schema {
  type?: string | string[];
  description?: string;
  default?: unknown;
  minimum?: number;
  maximum?: number;
  enum?: unknown[];
  const?: unknown;
  properties?: Record<string, Schema>;
  items?: Schema;
  required?: string[];
  anyOf?: Schema[];
  oneOf?: Schema[];
  allOf?: Schema[];
  if?: Schema;
  then?: Schema;
  $ref?: string;
  $defs?: Record<string, Schema>;
  "x-unit"?: string;
  "x-plugin"?: string;
  [key: string]: unknown;
}

export interface Load {
  path: string;
  case: string;
  seed: number;
  /** Lines `set.…` and `change.…`. */
  variation: string;
  /** Applied before the first tick. */
  changes: Change[];
  walls: Record<string, number[]>;
}

export type ToWorker =
  | { type: "keep"; path: string; bytes: Uint8Array }
  | ({ type: "load" } & Load)
  | { type: "reset"; seed: number; changes: Change[]; walls: Record<string, number[]> }
  | { type: "play"; on: boolean }
  | { type: "step" }
  | { type: "speed"; speed: number }
  | { type: "change"; change: Change }
  | { type: "pull"; frame: string; point: number[]; force: number[] }
  | { type: "wall"; name: string; point: number[] }
  | { type: "measure" }
  | { type: "matters"; on: boolean }
  | { type: "describe"; path: string; case: string; variation: string };

export type FromWorker =
  | { type: "ready"; scenarios: Shipped[]; schemas: { controller: Schema; scenario: Schema } }
  | { type: "loaded"; about: About; fields: Fields; frame: Float64Array; words: Words; problems: string[] }
  | { type: "described"; about: About; fields: Fields }
  | { type: "refused"; what: "load" | "describe"; text: string }
  | { type: "frame"; frame: Float64Array; rows: Float64Array; pace: number; playing: boolean; words: Words | null }
  | { type: "changed"; change: Change; problem: string | null }
  | { type: "measured"; title: string; rows: Row[]; seconds: number; simulated: number }
  | { type: "unmeasured"; text: string }
  | { type: "matters"; matters: Matters }
  | { type: "broken"; text: string };
