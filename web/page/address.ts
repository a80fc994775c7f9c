// The page's state in its address: scenario, case, seed, what was changed, and one's own text.

import type { Change } from "./protocol";

export interface State {
  scenario: string;
  case: string;
  seed: number;
  speed: number;
  /** What was changed of the running controller; the last of each kind. */
  changes: Change[];
  /** Lines `set.…` and `change.…` by key. */
  varied: Map<string, unknown>;
  /** Walls that were moved. */
  walls: Record<string, number[]>;
  /** One's own scenario and controller. */
  own: { scenario: string; controller: string } | null;
}

export function fresh(scenario: string, name: string): State {
  return { scenario, case: name, seed: 1, speed: 1, changes: [], varied: new Map(), walls: {}, own: null };
}

/** The changes with one more: what it replaces goes. */
export function joined(changes: Change[], change: Change): Change[] {
  const merged: Change = change;
  const rest = changes.filter((other) => {
    if (other.do !== change.do || other.of !== change.of) return true;
    if (other.do !== "set" || change.do !== "set") return false;
    if (merged.do === "set") merged.keys = { ...other.keys, ...change.keys };
    return false;
  });
  return change.do === "tare" ? rest : [...rest, merged];
}

/** TOML of a value that a slider can have. */
function toml(value: unknown): string {
  return typeof value === "number" && Number.isInteger(value) ? value.toFixed(1) : JSON.stringify(value);
}

export function variation(state: State): string {
  return [...state.varied].map(([key, value]) => `${key} = ${toml(value)}`).join("\n");
}

async function squeeze(text: string): Promise<string> {
  const stream = new Blob([text]).stream().pipeThrough(new CompressionStream("deflate-raw"));
  const bytes = new Uint8Array(await new Response(stream).arrayBuffer());
  let binary = "";
  for (const byte of bytes) binary += String.fromCharCode(byte);
  return btoa(binary).replace(/\+/g, "-").replace(/\//g, "_").replace(/=+$/, "");
}

async function unfold(text: string): Promise<string> {
  const bytes = Uint8Array.from(atob(text.replace(/-/g, "+").replace(/_/g, "/")), (c) => c.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate-raw"));
  return new Response(stream).text();
}

export async function write(state: State): Promise<string> {
  const hash = new URLSearchParams({ scenario: state.scenario, case: state.case, seed: String(state.seed) });
  if (state.speed !== 1) hash.set("speed", String(state.speed));
  if (state.changes.length > 0) hash.set("changes", JSON.stringify(state.changes));
  if (state.varied.size > 0) hash.set("with", JSON.stringify([...state.varied]));
  if (Object.keys(state.walls).length > 0) hash.set("walls", JSON.stringify(state.walls));
  if (state.own) hash.set("own", await squeeze(JSON.stringify(state.own)));
  return `#${hash}`;
}

/** What an address says; throws where it is damaged. */
export async function read(hash: string): Promise<State | null> {
  const said = new URLSearchParams(hash.replace(/^#/, ""));
  const scenario = said.get("scenario");
  if (!scenario) return null;
  const state = fresh(scenario, said.get("case") ?? "");
  const seed = Number(said.get("seed") ?? 1);
  state.seed = Number.isInteger(seed) && seed >= 0 && seed < 2 ** 32 ? seed : 1;
  state.speed = Number(said.get("speed") ?? 1) || 1;
  state.changes = list(said.get("changes")) as Change[];
  state.varied = new Map(list(said.get("with")) as [string, unknown][]);
  state.walls = JSON.parse(said.get("walls") ?? "{}");
  const own = said.get("own");
  if (own) state.own = JSON.parse(await unfold(own));
  return state;
}

function list(text: string | null): unknown[] {
  const value: unknown = JSON.parse(text ?? "[]");
  if (!Array.isArray(value)) throw new Error("a list is expected");
  return value;
}
