// Controller and plant in a worker: the module runs at the scenario's rates, the page only draws.

import start, { Run, keep, measured, scenarios, schemas } from "./pkg/wbqp.js";
import type { Change, FromWorker, Load, Matters, ToWorker, Words } from "./protocol";

/** Pause between two turns of the loop, ms: the page gets about sixty frames per second. */
const TURN = 14;
/** Most time that a turn computes, ms: requests are heard in between. */
const MOST = 24;
/** A turn that comes late makes up for no more than this, s. */
const LATE = 0.1;
/** Between two derivatives of ticks, ms, and of the time at least so many times what they take. */
const PAUSE = 300;
const REST = 9;

let memory: WebAssembly.Memory;
let run: Run | null = null;
let loaded: Load | null = null;
/** Of the scenario, s. */
let duration = 0;
let playing = false;
let speed = 1;
let last = 0;
/** Ticks that are owed, a fraction of one included. */
let owed = 0;
/** Simulated and real seconds since the pace was last taken. */
let simulated = 0;
let passed = 0;
let pace = 0;
let lastWords = "";
/** Whether the page wants to know what matters; when it is told next, and of which time it was told. */
let watching = false;
let tellAt = 0;
let toldOf = -1;

function say(message: FromWorker, transfer: Transferable[] = []): void {
  (self as unknown as Worker).postMessage(message, transfer);
}

function text(error: unknown): string {
  return error instanceof Error ? error.message : String(error);
}

/** An error of the module itself: nothing of it can be used any more. */
function isBroken(error: unknown): boolean {
  return error instanceof WebAssembly.RuntimeError;
}

function frameOf(run: Run): Float64Array {
  const at = run.frame();
  return new Float64Array(memory.buffer, at, run.frame_length()).slice();
}

function send(run: Run): void {
  const frame = frameOf(run);
  const at = run.rows();
  const rows = new Float64Array(memory.buffer, at, run.rows_length()).slice();
  const words = run.words();
  // The time alone is no news.
  const parsed = JSON.parse(words) as Words;
  const news = JSON.stringify({ ...parsed, time: 0 });
  const changed = news !== lastWords;
  lastWords = news;
  say({ type: "frame", frame, rows, pace, playing, words: changed ? parsed : null }, [frame.buffer, rows.buffer]);
}

/** Says what matters in the last tick, if somebody looks, now and then. */
function sayMatters(run: Run): void {
  const begin = performance.now();
  if (!watching || begin < tellAt || run.time() === toldOf) return;
  say({ type: "matters", matters: JSON.parse(run.matters()) as Matters });
  toldOf = run.time();
  const end = performance.now();
  tellAt = end + Math.max(PAUSE, REST * (end - begin));
}

function turn(): void {
  const now = performance.now();
  const real = Math.min((now - last) / 1000, LATE);
  last = now;
  try {
    if (run && playing) {
      const before = run.time();
      const wasOver = run.is_over();
      const most = Number.isFinite(speed) ? (owed += (speed * real) / run.period()) : 1e6;
      // However fast it goes, it stops at the scenario's end; from there it may go on.
      const left = wasOver ? Infinity : Math.max(1, Math.round((duration - before) / run.period()));
      const done = run.advance_within(Math.min(Math.floor(most), left), MOST);
      // What cannot be had in time is not owed: the pace says so.
      owed = Number.isFinite(speed) ? Math.min(owed - done, LATE / run.period()) : 0;
      simulated += run.time() - before;
      passed += real;
      if (passed > 0.5) {
        pace = simulated / passed;
        simulated = passed = 0;
      }
      if (run.is_stopped() || (run.is_over() && !wasOver)) playing = false;
      send(run);
      // The last one is of where it stands.
      if (!playing) tellAt = 0;
      sayMatters(run);
    }
  } catch (error) {
    playing = false;
    run = null;
    say({ type: "broken", text: text(error) });
  }
  setTimeout(turn, TURN);
}

/** Applies what was changed before the first tick; says what is refused. */
function prepare(run: Run, changes: Change[], walls: Record<string, number[]>): string[] {
  const problems: string[] = [];
  for (const change of changes) {
    try {
      run.change(JSON.stringify(change));
    } catch (error) {
      if (isBroken(error)) throw error;
      problems.push(text(error));
    }
  }
  for (const [name, [x, y, z]] of Object.entries(walls)) {
    if (!run.move_wall(name, x, y, z)) problems.push(`there is no wall \`${name}\` to be moved`);
  }
  return problems;
}

function show(next: Run, problems: string[]): void {
  run?.free();
  run = next;
  playing = false;
  owed = simulated = passed = pace = 0;
  lastWords = "";
  const words = JSON.parse(run.words()) as Words;
  const about = JSON.parse(run.about());
  duration = about.duration;
  const fields = JSON.parse(run.fields());
  const frame = frameOf(run);
  say({ type: "loaded", about, fields, frame, words, problems }, [frame.buffer]);
  tellAt = 0;
  toldOf = -1;
  sayMatters(run);
}

/** Runs every case of the scenario as fast as it goes, and measures the paper's rows. */
function measure(load: Load, cases: string[]): void {
  const begin = performance.now();
  const runs: Run[] = [];
  try {
    let total = 0;
    for (const name of cases) {
      const each = new Run(load.path, name, load.seed, load.variation);
      runs.push(each);
      prepare(each, load.changes, load.walls);
      while (!each.is_over() && !each.is_stopped()) each.advance(1000);
      total += each.time();
    }
    const seconds = (performance.now() - begin) / 1000;
    const rows = JSON.parse(measured(runs.splice(0)));
    say({ type: "measured", title: rows.title, rows: rows.rows, seconds, simulated: total });
  } catch (error) {
    if (isBroken(error)) throw error;
    say({ type: "unmeasured", text: text(error) });
  } finally {
    for (const each of runs) each.free();
  }
}

function hear(message: ToWorker): void {
  switch (message.type) {
    case "keep":
      keep(message.path, message.bytes);
      break;
    case "load":
      try {
        const { path, seed, variation, changes, walls } = message;
        const next = new Run(path, message.case, seed, variation);
        loaded = message;
        show(next, prepare(next, changes, walls));
      } catch (error) {
        if (isBroken(error)) throw error;
        say({ type: "refused", what: "load", text: text(error) });
      }
      break;
    case "reset":
      if (run && loaded) {
        loaded = { ...loaded, seed: message.seed, changes: message.changes, walls: message.walls };
        const next = run.again(message.seed);
        show(next, prepare(next, message.changes, message.walls));
      }
      break;
    case "play":
      playing = message.on;
      last = performance.now();
      owed = 0;
      if (run) {
        send(run);
        tellAt = 0;
        sayMatters(run);
      }
      break;
    case "step":
      playing = false;
      if (run) {
        run.advance(1);
        send(run);
        tellAt = 0;
        sayMatters(run);
      }
      break;
    case "speed":
      speed = message.speed;
      owed = simulated = passed = 0;
      break;
    case "change": {
      let problem: string | null = null;
      try {
        run?.change(JSON.stringify(message.change));
      } catch (error) {
        if (isBroken(error)) throw error;
        problem = text(error);
      }
      say({ type: "changed", change: message.change, problem });
      break;
    }
    case "pull": {
      const [[x, y, z], [fx, fy, fz]] = [message.point, message.force];
      run?.pull(message.frame, x, y, z, fx, fy, fz);
      break;
    }
    case "wall": {
      const [x, y, z] = message.point;
      run?.move_wall(message.name, x, y, z);
      if (run && !playing) send(run);
      break;
    }
    case "matters":
      watching = message.on;
      tellAt = 0;
      toldOf = -1;
      if (!run) break;
      if (watching) sayMatters(run);
      else run.forget_matters();
      break;
    case "measure":
      if (run && loaded) measure(loaded, JSON.parse(run.about()).cases);
      break;
    case "describe":
      try {
        const other = new Run(message.path, message.case, 1, message.variation);
        say({ type: "described", about: JSON.parse(other.about()), fields: JSON.parse(other.fields()) });
        other.free();
      } catch (error) {
        if (isBroken(error)) throw error;
        say({ type: "refused", what: "describe", text: text(error) });
      }
      break;
  }
}

try {
  memory = (await start()).memory;
  self.onmessage = ({ data }: MessageEvent<ToWorker>) => {
    try {
      hear(data);
    } catch (error) {
      run = null;
      playing = false;
      say({ type: "broken", text: text(error) });
    }
  };
  say({ type: "ready", scenarios: JSON.parse(scenarios()), schemas: JSON.parse(schemas()) });
  last = performance.now();
  turn();
} catch (error) {
  say({ type: "broken", text: text(error) });
}
