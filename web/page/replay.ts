// A log, MCAP, in memory: what it says of each tick, in the form in which a running simulation says it.

import { McapIndexedReader } from "@mcap/core";
import { decompress } from "fzstd";
import type { About, Contact, Field, Fields } from "./protocol";

// What a message holds, by its schema; what is not there is undefined.
type Json = any;

/** Frames that are kept; of a longer log only every second, third, …. */
const MOST = 20_000;

export interface Source {
  /** The files that the run was made from, by name. */
  files: Map<string, Uint8Array>;
  scenario: string;
  case: string;
  variation: string;
  marks: { name: string; at: number }[];
  messages: Map<number, Map<string, Json>>;
}

/** Reads a log; throws what is wrong with it, in words. */
export async function read(bytes: Uint8Array): Promise<Source> {
  const readable = {
    size: async () => BigInt(bytes.length),
    read: async (offset: bigint, length: bigint) => {
      if (offset + length > BigInt(bytes.length))
        throw new Error("the file ends before what its index names: it is cut off");
      return bytes.subarray(Number(offset), Number(offset + length));
    },
  };
  const reader = await McapIndexedReader.Initialize({
    readable,
    decompressHandlers: { zstd: (data, size) => decompress(new Uint8Array(data), new Uint8Array(Number(size))) },
  });
  const source: Source = { files: new Map(), scenario: "", case: "", variation: "", marks: [], messages: new Map() };
  const text = new TextDecoder();
  for await (const attachment of reader.readAttachments()) {
    const copy = new Uint8Array(attachment.data);
    source.files.set(attachment.name, copy);
    if (attachment.name === "variation.toml") source.variation = text.decode(copy);
    else if (attachment.name.endsWith(".toml") && /^\s*\[\[case\]\]/m.test(text.decode(copy)))
      source.scenario ||= attachment.name;
  }
  for await (const metadata of reader.readMetadata()) {
    if (metadata.name === "scenario") source.case = metadata.metadata.get("case") ?? "";
    if (metadata.name === "timeline") {
      for (const [name, at] of metadata.metadata)
        if (Number.isFinite(Number(at))) source.marks.push({ name, at: Number(at) });
    }
  }
  if (!source.scenario) throw new Error("it has no scenario attached: only logs of this project's runs can be drawn");
  for await (const message of reader.readMessages()) {
    const channel = reader.channelsById.get(message.channelId);
    if (channel?.messageEncoding !== "json") continue;
    const time = Number(message.logTime);
    let tick = source.messages.get(time);
    if (!tick) source.messages.set(time, (tick = new Map()));
    tick.set(channel.topic, JSON.parse(text.decode(message.data)));
  }
  if (source.messages.size === 0) throw new Error("it has no messages");
  return source;
}

const LEVELS = ["optimal", "relaxed", "extrapolated", "safe"];

export class Replay {
  readonly frames: Float64Array[] = [];
  readonly rows: Float64Array;
  readonly times: number[] = [];
  /** What the log says of faults: from when, the level, and why. */
  readonly faults: { at: number; level: string; text: string }[] = [];

  constructor(source: Source, about: About, fields: Fields) {
    const width = fields.history.reduce((sum, field) => sum + field.count, 0);
    const every = Math.ceil(source.messages.size / MOST);
    const rows: number[] = [];
    let index = 0;
    let last = new Map<string, Json>();
    let level = "optimal";
    for (const [time, tick] of [...source.messages].sort(([a], [b]) => a - b)) {
      // What a tick does not say is what was said last.
      last = new Map([...last, ...tick]);
      const qp = tick.get("/qp");
      if (qp && qp.level !== level) {
        level = qp.level;
        const short = (what: Json[] | undefined) =>
          (what ?? []).map((l) => `\n  ${l.row}: ${l.side} limit ${l.limit}, short by ${l.short}`).join("");
        this.faults.push({ at: time / 1e9, level, text: `${qp.fault ?? ""}${short(qp.conflict)}` });
      }
      if (index++ % every !== 0) continue;
      this.times.push(time / 1e9);
      this.frames.push(frame(fields.frame, about, last, time / 1e9));
      const row = history(fields.history, about, last, time / 1e9);
      if (row.length === width) rows.push(...row);
    }
    this.rows = Float64Array.from(rows);
  }

  get end(): number {
    return this.times.at(-1) ?? 0;
  }

  /** Index of the last frame at or before a time. */
  at(time: number): number {
    let [low, high] = [0, this.times.length - 1];
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (this.times[middle] <= time) low = middle;
      else high = middle - 1;
    }
    return low;
  }

  faultAt(time: number): { at: number; level: string; text: string } | null {
    return this.faults.filter((fault) => fault.at <= time).at(-1) ?? null;
  }
}

const xyz = (value: Json | undefined): number[] => (value ? [value.x, value.y, value.z] : [NaN, NaN, NaN]);

/** A vector of a surface's axes in the world's. */
function turned(contact: Contact, v: number[]): number[] {
  const a = contact.axes;
  return [0, 1, 2].map((i) => a[i] * v[0] + a[3 + i] * v[1] + a[6 + i] * v[2]);
}

function frame(fields: Field[], about: About, said: Map<string, Json>, time: number): Float64Array {
  const out = new Float64Array(fields.reduce((sum, field) => sum + field.count, 0));
  const state = said.get("/plant") ?? said.get("/state");
  const command = said.get("/command");
  const contacts = new Map(about.contacts.map((contact) => [contact.name, contact]));
  for (const { name, at, count } of fields) {
    const put = (values: number[]) => values.slice(0, count).forEach((value, i) => (out[at + i] = value));
    const [kind, whose, what] = name.split("/");
    const contact = contacts.get(whose);
    const report = said.get(`/contact/${whose}`);
    if (name === "time") put([time]);
    else if (name === "level") put([LEVELS.indexOf(said.get("/qp")?.level ?? "optimal")]);
    else if (name === "tick_us") put([said.get("/qp")?.times?.total ?? 0]);
    else if (name === "position") put(xyz(state?.base?.position));
    else if (name === "quaternion") {
      const Q = state?.base?.orientation;
      put(Q ? [Q.x, Q.y, Q.z, Q.w] : [0, 0, 0, 1]);
    } else if (name === "joints") put(about.joints.map((joint) => state?.joints?.[joint.name]?.position ?? 0));
    else if (name === "efforts") put(efforts(about, command));
    else if (kind === "wall") put(about.walls.find((wall) => wall.name === whose)?.point ?? [0, 0, 0]);
    else if (kind === "contact" && contact) {
      if (what === "switch") put([report?.active ? 1 : 0, report?.alpha ?? 0, 0, 0]);
      else if (what === "normal") put(contact.axes.slice(6, 9));
      else if (what === "point") {
        const p = turned(contact, xyz(report?.true_position ?? report?.position));
        put(p.map((x, i) => x + contact.origin[i]));
      } else {
        const force = report?.[{ planned: "solution", measured: "measured", true: "truth" }[what] ?? ""];
        put(force ? turned(contact, xyz(force)) : [0, 0, 0]);
      }
    } else if (kind === "reference") put(references(said.get(`/task/${whose}`)));
    else if (kind === "task" && what === "alpha") {
      // Older logs have no references: without a ramp their markers are not drawn.
      const task = said.get(`/task/${whose}`);
      put([references(task).length > 0 ? (task?.alpha ?? 0) : 0]);
    }
  }
  return out;
}

/** What the rows of a task should become, in their order. */
function references(task: Json | undefined): number[] {
  const rows: Json[] = Object.values(task?.rows ?? {});
  return rows.map((row) => row.reference).filter((value) => typeof value === "number");
}

function efforts(about: About, command: Json | undefined): number[] {
  return about.actuators.map(
    ({ name, rotor }) => (rotor !== null ? command?.rotors?.[name]?.thrust : command?.joints?.[name]?.effort) ?? NaN,
  );
}

function history(fields: Field[], about: About, said: Map<string, Json>, time: number): number[] {
  return fields.flatMap(({ name, count }) => {
    const [kind, whose] = name.split("/");
    if (name === "time") return [time];
    if (name === "tick_us") return [said.get("/qp")?.times?.total ?? NaN];
    if (name === "level") return [LEVELS.indexOf(said.get("/qp")?.level ?? "optimal")];
    if (name === "efforts") return efforts(about, said.get("/command"));
    if (kind === "force") {
      const c = said.get(`/contact/${whose}`);
      return [c?.reference?.z ?? NaN, c?.solution?.z ?? NaN, c?.measured?.z ?? NaN, c?.truth?.z ?? NaN];
    }
    if (kind === "error") {
      const rows = Object.values(said.get(`/task/${whose}`)?.rows ?? {}) as Json[];
      return [Math.sqrt(rows.reduce((sum, row) => sum + (row.error ?? 0) ** 2, 0))];
    }
    return Array<number>(count).fill(NaN);
  });
}
