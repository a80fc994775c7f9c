// The page: who hears what.

import "./style.css";
import { type State, fresh, joined, read as readAddress, variation, write as writeAddress } from "./address";
import type { Editor, Tab } from "./editor";
import { type Named, fetchLog, namedLog } from "./fetched";
import { MattersPanel } from "./matters";
import { Panel } from "./panel";
import { Plots } from "./plots";
import type { About, Change, Fields, FromWorker, Matters, Row, Schema, Shipped, ToWorker, Words } from "./protocol";
import type { Replay, Source } from "./replay";
import { Scene } from "./scene";
import { WordBox } from "./words";

function $<T extends HTMLElement = HTMLElement>(id: string): T {
  const found = document.getElementById(id);
  if (!found) throw new Error(`the page has no #${id}`);
  return found as T;
}

const OWN = "own";
/** Of the scenarios to choose, the log that is shown. */
const LOG = "a log";
/** Where one's own files are kept, for the module. */
const FOLDER = "own";

const worker = new Worker(new URL("./worker.ts", import.meta.url), { type: "module" });
const tell = (message: ToWorker) => worker.postMessage(message);

let shipped: Shipped[] = [];
let schemas: { controller: Schema; scenario: Schema };
let state: State = fresh("", "");
let about: About | null = null;
let fields: Fields | null = null;
let playing = false;
let editor: Editor | null = null;
let panel: Panel | null = null;
let replay: Replay | null = null;
let source: Source | null = null;
let logName = "";
/** The log that the page's address names. */
let named: Named | null = null;
/** What the address begins with is there, or is refused: from now on other things may be shown. */
let settle: () => void = () => {};
const settled = new Promise<void>((done) => (settle = done));
/** What is wrong with the link, to be said when something is there to be seen. */
let greeting: [string, string] | null = null;
/** Meshes and other files that were dropped. */
const dropped = new Map<string, File>();
let latest: Float64Array | null = null;
let words: Words | null = null;

const said = new WordBox($("say"));
const wrong = new WordBox($("problem"));
let scene: Scene | null = null;
const plots = new Plots($("plots"));
const matters = new MattersPanel($<HTMLDetailsElement>("matters"), (on) => tell({ type: "matters", on }));
let lastMatters: Matters | null = null;
try {
  scene = new Scene(
    $("stage"),
    {
      pull: (frame, point, force) => !replay && tell({ type: "pull", frame, point, force }),
      wall: (name, point) => {
        if (replay) return;
        state.walls[name] = point.map((x) => Math.round(x * 1e4) / 1e4);
        tell({ type: "wall", name, point });
        remember();
      },
    },
    { find: (name) => dropped.get(name) ?? null },
  );
} catch (error) {
  problem("3-D is not available", `This browser gives no WebGL: ${String(error)}. Plots and parameters work without.`);
}

// Words.

function problem(title: string, text: string): void {
  wrong.show(text, title);
}

function calm(): void {
  wrong.hide();
}

function speak(now: Words): void {
  words = now;
  const level = $("level");
  level.textContent = now.stopped ? "stopped" : now.level;
  level.dataset.level = now.stopped ? "safe" : now.level;
  const parts: string[] = [];
  if (now.stopped) parts.push(now.stopped);
  if (now.why) parts.push(now.why);
  else if (now.last && now.time - now.last.at < 3) parts.push(`at ${now.last.at.toFixed(3)} s, ${now.last.why}`);
  if (now.over && !now.stopped) parts.push("The scenario is over: Reset begins again, Play goes on.");
  said.show(parts.join("\n\n"));
}

// The run.

let remembering = 0;
function remember(): void {
  clearTimeout(remembering);
  remembering = window.setTimeout(async () => history.replaceState(null, "", await writeAddress(state)), 250);
}

function pathOf(): string {
  return state.scenario === OWN
    ? `${FOLDER}/scenario.toml`
    : (shipped.find((s) => s.name === state.scenario)?.path ?? state.scenario);
}

function load(): void {
  if (state.own && state.scenario === OWN) keepOwn(state.own);
  setPlaying(false);
  tell({
    type: "load",
    path: pathOf(),
    case: state.case,
    seed: state.seed,
    variation: variation(state),
    changes: state.changes,
    walls: state.walls,
  });
  remember();
}

function keepOwn(own: { scenario: string; controller: string }): void {
  const bytes = (text: string) => new TextEncoder().encode(text);
  tell({ type: "keep", path: `${FOLDER}/scenario.toml`, bytes: bytes(own.scenario) });
  tell({ type: "keep", path: `${FOLDER}/controller.toml`, bytes: bytes(own.controller) });
}

function setPlaying(on: boolean): void {
  playing = on;
  const play = $("play");
  play.querySelector("path")?.setAttribute("d", on ? "M3 2h4v12H3zM9 2h4v12H9z" : "M4 2v12l10-6z");
  play.setAttribute("aria-label", on ? "Pause" : "Play");
}

function change(change: Change): void {
  state.changes = joined(state.changes, change);
  tell({ type: "change", change });
  remember();
}

function vary(key: string, value: unknown): void {
  state.varied.set(key, value);
  load();
}

function show(next: About, where: Fields): void {
  about = next;
  fields = where;
  scene?.load(next, where.frame);
  plots.load(next, where.history);
  const cases = $<HTMLSelectElement>("case");
  cases.replaceChildren(...next.cases.map((name) => new Option(name.replace(/_/g, " "), name)));
  cases.value = next.case;
  cases.disabled = next.cases.length < 2;
}

function clock(time: number): void {
  $("time").textContent = `${time.toFixed(2)} s`;
  if (about) $<HTMLProgressElement>("progress").value = Math.min(1, time / about.duration);
}

function field(name: string): Float64Array | null {
  const found = fields?.frame.find((f) => f.name === name);
  return found && latest ? latest.subarray(found.at, found.at + found.count) : null;
}

function draw(frame: Float64Array): void {
  latest = frame;
  scene?.show(frame);
  clock(field("time")?.[0] ?? 0);
  const tick = field("tick_us")?.[0] ?? 0;
  $("tick").textContent = tick > 0 ? `${tick.toFixed(0)} µs/tick` : "";
}

worker.onmessage = ({ data }: MessageEvent<FromWorker>) => hear(data);
worker.onerror = (event) =>
  problem("The simulation cannot start", event.message || "the worker's script was not loaded");

async function hear(message: FromWorker): Promise<void> {
  switch (message.type) {
    case "ready":
      shipped = message.scenarios;
      schemas = message.schemas;
      await begin();
      await beginWithLog();
      break;
    case "loaded": {
      calm();
      leaveLog();
      state.case = message.about.case;
      show(message.about, message.fields);
      panel ??= new Panel($("side"), schemas, { change, vary });
      const begun = withChanges(message.about);
      panel.load(begun, state.varied);
      $("about").textContent =
        shipped.find((s) => s.name === state.scenario)?.about ?? message.about.diagnostics.slice(0, 3).join("\n");
      speak(message.words);
      $("pace").textContent = "";
      draw(message.frame);
      if (greeting) problem(...greeting);
      greeting = null;
      if (message.problems.length > 0)
        problem("Not everything of the link could be applied", message.problems.join("\n"));
      editor?.mark("");
      if ($<HTMLDialogElement>("editor").open && state.scenario === OWN) {
        $("refusal").hidden = true;
        $<HTMLDialogElement>("editor").close();
      }
      document.body.dataset.loaded = state.scenario;
      settle();
      break;
    }
    case "refused":
      if (message.what === "load") settle();
      if (message.what === "describe") {
        source = null;
        problem(`The log ${logName} cannot be drawn`, `What it was made from is refused:\n${message.text}`);
      } else if ($<HTMLDialogElement>("editor").open) {
        $("refusal").textContent = plain(message.text);
        $("refusal").hidden = false;
        editor?.mark(message.text);
      } else {
        problem("The scenario is refused", plain(message.text));
      }
      break;
    case "described":
      await begun(message.about, message.fields);
      break;
    case "frame":
      if (replay) break;
      plots.add(message.rows);
      draw(message.frame);
      if (message.playing !== playing) setPlaying(message.playing);
      $("pace").textContent =
        message.pace > 0 && playing ? `${message.pace.toFixed(message.pace < 10 ? 2 : 0)}× real time` : "";
      if (message.words) speak(message.words);
      else if (words && !words.why && words.last && (field("time")?.[0] ?? 0) - words.last.at > 3) {
        speak({ ...words, time: Infinity });
      }
      break;
    case "changed":
      if (message.problem) problem(`${message.change.of} stays as it was`, message.problem);
      else calm();
      break;
    case "measured":
      results(message.title, message.rows, message.simulated / message.seconds);
      break;
    case "matters":
      lastMatters = message.matters;
      if (!replay) matters.show(message.matters);
      break;
    case "unmeasured":
      problem("There is nothing to measure", message.text);
      break;
    case "broken":
      setPlaying(false);
      problem(
        "The module has stopped",
        `${message.text}\nReload the page; a link that ends like this is worth a report.`,
      );
      break;
  }
}

/** Paths of the module's memory are nothing that a reader knows. */
function plain(text: string): string {
  return text.replace(new RegExp(`\\b${FOLDER}/`, "g"), "");
}

/** What the sliders show first: the file's values with what was changed. */
function withChanges(about: About): About {
  const entries = about.entries.map((entry) => {
    const changed = structuredClone(entry);
    for (const change of state.changes) {
      if (change.of !== entry.name) continue;
      if (change.do === "set") Object.assign(changed.parameters, change.keys);
      else if (change.do === "weight") changed.weight = change.value;
      else if (change.do === "entry") changed.active = change.on;
      else if (change.do === "follow" && changed.reference) {
        const to = change.reference.to ?? change.reference.value;
        if (Array.isArray(to)) changed.reference.value = to as number[];
      }
    }
    return changed;
  });
  const contacts = about.contacts.map((contact) => {
    const change = state.changes.findLast((c) => c.do === "contact" && c.of === contact.name);
    return change?.do === "contact" ? { ...contact, active: change.on } : contact;
  });
  return { ...about, entries, contacts };
}

async function begin(): Promise<void> {
  const choice = $<HTMLSelectElement>("scenario");
  choice.replaceChildren(...shipped.map((s) => new Option(s.title, s.name)), new Option("Your own…", OWN));
  const first = shipped[0];
  state = fresh(first.name, first.case);
  try {
    const said = await readAddress(location.hash);
    if (said) {
      state = said;
      if (state.scenario === OWN && !state.own) state.own = template();
      if (state.scenario !== OWN && !shipped.some((s) => s.name === state.scenario)) {
        const known = shipped.map((s) => s.name).join(", ");
        const name = state.scenario;
        state = fresh(first.name, first.case);
        greeting = [
          "The link is of another page",
          `There is no scenario \`${name}\`; known: ${known}. This is the first.`,
        ];
      }
    }
  } catch (error) {
    state = fresh(first.name, first.case);
    greeting = ["The link is damaged", `${String(error)}\nThis is the first scenario as it ships.`];
  }
  choice.value = state.scenario;
  $<HTMLInputElement>("seed").value = String(state.seed);
  const speed = $<HTMLSelectElement>("speed");
  if ([...speed.options].some((o) => Number(o.value) === state.speed)) speed.value = String(state.speed);
  tell({ type: "speed", speed: state.speed });
  load();
}

// One's own text.

/** What one's own begins with: the scenario that is shown. */
function template(): { scenario: string; controller: string } {
  const from = shipped.find((s) => s.name === state.scenario) ?? shipped[0];
  return {
    scenario: from.text.replace(/^controller = .*$/m, 'controller = "controller.toml"'),
    controller: from.controller,
  };
}

async function edit(): Promise<void> {
  let Editor;
  try {
    ({ Editor } = await import("./editor"));
  } catch (error) {
    return problem("The editor cannot be loaded", `Is what serves this page still there? ${String(error)}`);
  }
  const own = state.scenario === OWN && state.own ? state.own : template();
  editor ??= new Editor($("text"), $("tabs"), schemas, apply);
  const tabs: Tab[] = [
    { key: "controller", file: "controller.toml", text: own.controller },
    { key: "scenario", file: "scenario.toml", text: own.scenario },
  ];
  $("refusal").hidden = true;
  $<HTMLDialogElement>("editor").showModal();
  editor.open(tabs);
}

function apply(): void {
  if (!editor) return;
  const own = { scenario: editor.text("scenario"), controller: editor.text("controller") };
  const { seed, speed } = state;
  const name = state.scenario === OWN ? state.case : "";
  state = { ...fresh(OWN, name), seed, speed, own };
  $<HTMLSelectElement>("scenario").value = OWN;
  // A case that the text has no more is no reason to refuse it.
  if (name && !new RegExp(`name\\s*=\\s*["']${name}["']`).test(own.scenario)) state.case = "";
  load();
}

// Logs and robots of others.

async function open(files: File[]): Promise<void> {
  calm();
  for (const file of files) dropped.set(file.name, file);
  const log = files.find((file) => file.name.endsWith(".mcap"));
  const urdf = files.find((file) => /\.(urdf|xml)$/.test(file.name));
  if (log) await openLog(log);
  else if (urdf) await openRobot(urdf);
  else
    problem(
      "Nothing to open",
      `${files.map((f) => f.name).join(", ")}: a log ends in .mcap, a robot in .urdf (with its meshes beside it)`,
    );
}

async function openRobot(file: File): Promise<void> {
  const text = await file.text();
  tell({ type: "keep", path: `${FOLDER}/${file.name}`, bytes: new TextEncoder().encode(text) });
  const name = file.name.replace(/\.\w+$/, "").replace(/[^\w-]/g, "_");
  const controller = `# A posture that holds ${file.name} at rest. A robot without a floating base needs no contacts.
[controller]
rate = 500.0

[robot]
type = "urdf"
file = "${file.name}"
base = "fixed"

[[task]]
type = "posture"
weight = 1.0
kp = 100.0
kd = 20.0

[[constraint]]
type = "actuator_limits"
`;
  const scenario = `name = "${name}"
controller = "controller.toml"
duration = 20.0

[[case]]
name = "hold"
`;
  const { seed, speed } = state;
  state = { ...fresh(OWN, ""), seed, speed, own: { scenario, controller } };
  $<HTMLSelectElement>("scenario").value = OWN;
  load();
}

/** The log that the address names, when there is something behind it that stays if it cannot be shown. */
async function beginWithLog(): Promise<void> {
  await settled;
  try {
    named = namedLog(location.href);
  } catch (error) {
    return problem("The log is not fetched", error instanceof Error ? error.message : String(error));
  }
  if (!named) return;
  $("reload").hidden = false;
  await reload();
}

async function reload(): Promise<void> {
  if (!named) return;
  calm();
  const button = $<HTMLButtonElement>("reload");
  button.disabled = true;
  try {
    await openLog(await fetchLog(named));
  } catch (error) {
    problem(`The log ${named.name} cannot be fetched`, error instanceof Error ? error.message : String(error));
  } finally {
    button.disabled = false;
  }
}

async function openLog(file: File): Promise<void> {
  setPlaying(false);
  tell({ type: "play", on: false });
  logName = file.name;
  try {
    const { read } = await import("./replay");
    source = await read(new Uint8Array(await file.arrayBuffer()));
  } catch (error) {
    source = null;
    problem(`The log ${file.name} cannot be read`, error instanceof Error ? error.message : String(error));
    return;
  }
  for (const [name, bytes] of source.files) tell({ type: "keep", path: `log/${name}`, bytes: bytes.slice() });
  tell({ type: "describe", path: `log/${source.scenario}`, case: source.case, variation: source.variation });
}

async function begun(next: About, where: Fields): Promise<void> {
  if (!source) return;
  const { Replay } = await import("./replay");
  // A log that is read again stays where it was.
  const at = document.body.dataset.replay === logName ? replayed : 0;
  show(next, where);
  replay = new Replay(source, next, where);
  source = null;
  document.body.dataset.replay = logName;
  const frames = replay.times.length;
  $("about").textContent =
    `Log ${logName}: ${next.scenario}, case ${next.case}, ${frames} frames. Choose a scenario to leave it.`;
  offerLog(logName);
  const cases = $<HTMLSelectElement>("case");
  cases.replaceChildren(new Option(next.case.replace(/_/g, " "), next.case));
  cases.disabled = true;
  const scrub = $<HTMLInputElement>("scrub");
  scrub.hidden = false;
  $("progress").hidden = true;
  scrub.max = String(replay.end);
  plots.all = true;
  plots.add(replay.rows);
  seek(at);
}

let replayed = 0;
function seek(time: number): void {
  if (!replay) return;
  replayed = Math.min(Math.max(0, time), replay.end);
  const index = replay.at(replayed);
  $<HTMLInputElement>("scrub").value = String(replayed);
  plots.cursor = replayed;
  plots.refresh();
  draw(replay.frames[index]);
  const fault = replay.faultAt(replayed);
  const isFault = fault !== null && fault.level !== "optimal";
  speak({
    time: replayed,
    level: (fault?.level ?? "optimal") as Words["level"],
    why: isFault ? `${fault.level} since ${fault.at.toFixed(3)} s: ${fault.text}` : null,
    last: null,
    stopped: null,
    over: false,
  });
}

/** The log's name stands where the scenario's stood; without a name, the scenario's again. */
function offerLog(name: string | null): void {
  const choice = $<HTMLSelectElement>("scenario");
  choice.querySelector(`option[value="${LOG}"]`)?.remove();
  if (name !== null) choice.prepend(new Option(`Log: ${name}`, LOG));
  choice.value = name === null ? state.scenario : LOG;
}

function leaveLog(): void {
  // What is shown now is another thing than the log of the address; the button has it still.
  if (replay && location.search) history.replaceState(null, "", location.pathname + location.hash);
  replay = null;
  delete document.body.dataset.replay;
  plots.all = false;
  plots.cursor = null;
  $("scrub").hidden = true;
  $("progress").hidden = false;
  offerLog(null);
}

let before = performance.now();
setInterval(() => {
  const now = performance.now();
  if (replay && playing) {
    seek(replayed + (Math.min(state.speed, 100) * (now - before)) / 1000);
    if (replayed >= replay.end) setPlaying(false);
  }
  before = now;
}, 25);

// Results.

function results(title: string, rows: Omit<Row, "promised">[], pace: number): void {
  $("results-title").textContent = title;
  const number = (x: number | null) => (x === null ? "–" : String(Number(x.toPrecision(4))));
  const table = document.createElement("table");
  const head = table.createTHead().insertRow();
  for (const text of ["", "row", "quantity", "paper", "here", "unit", "accepted"]) {
    head.append(Object.assign(document.createElement("th"), { textContent: text, scope: "col" }));
  }
  const body = table.createTBody();
  for (const row of rows) {
    const line = body.insertRow();
    line.dataset.row = row.id;
    const verdict = row.pass === null ? "" : row.pass ? "✓" : "✗";
    for (const text of [
      verdict,
      row.id,
      row.quantity,
      number(row.paper),
      number(row.measured),
      row.unit,
      row.tolerance,
    ]) {
      line.insertCell().textContent = text;
    }
    line.cells[0].className = row.pass === null ? "" : row.pass ? "pass" : "fail";
    line.cells[0].setAttribute("aria-label", row.pass === null ? "informative" : row.pass ? "met" : "missed");
  }
  const note = document.createElement("p");
  note.textContent = `Measured in this browser from runs at ${pace.toFixed(0)}× real time.`;
  note.dataset.pace = String(pace);
  $("results-table").replaceChildren(note, table);
  $<HTMLDialogElement>("results").showModal();
}

// What is pressed.

const toggle = () => {
  setPlaying(!playing);
  if (replay) {
    if (playing && replayed >= replay.end) seek(0);
  } else {
    tell({ type: "play", on: playing });
  }
};
const reset = () => {
  if (replay) seek(0);
  else tell({ type: "reset", seed: state.seed, changes: state.changes, walls: state.walls });
};
const stepOnce = () => {
  setPlaying(false);
  if (replay) seek(replay.times[Math.min(replay.at(replayed) + 1, replay.times.length - 1)]);
  else tell({ type: "step" });
};
$("play").onclick = toggle;
$("step").onclick = stepOnce;
$("reset").onclick = reset;
$("edit").onclick = () => void edit();
$("apply").onclick = apply;
$("close").onclick = () => $<HTMLDialogElement>("editor").close();
$("results-close").onclick = () => $<HTMLDialogElement>("results").close();
$("measure").onclick = () => {
  setPlaying(false);
  tell({ type: "play", on: false });
  tell({ type: "measure" });
};
$("reload").onclick = () => void reload();
$("open").onclick = () => $("files").click();
$<HTMLInputElement>("files").onchange = (event) => {
  const input = event.target as HTMLInputElement;
  void open([...(input.files ?? [])]);
  input.value = "";
};
$("link").onclick = async () => {
  const hash = await writeAddress(state);
  history.replaceState(null, "", hash);
  const button = $("link");
  try {
    await navigator.clipboard.writeText(location.href);
    button.textContent = "Copied";
  } catch {
    button.textContent = "In the address bar";
  }
  setTimeout(() => (button.textContent = "Link"), 1500);
};
$<HTMLSelectElement>("scenario").onchange = (event) => {
  const name = (event.target as HTMLSelectElement).value;
  // It is shown already: what was chosen instead was refused.
  if (name === LOG) return;
  const { seed, speed } = state;
  if (name === OWN) {
    state = { ...fresh(OWN, ""), seed, speed, own: template() };
    load();
    void edit();
    return;
  }
  const chosen = shipped.find((s) => s.name === name);
  state = { ...fresh(name, chosen?.case ?? ""), seed, speed };
  load();
};
$<HTMLSelectElement>("case").onchange = (event) => {
  state.case = (event.target as HTMLSelectElement).value;
  load();
};
$<HTMLInputElement>("seed").onchange = (event) => {
  const seed = Number((event.target as HTMLInputElement).value);
  if (!Number.isInteger(seed) || seed < 0 || seed >= 2 ** 32)
    return problem("The seed stays as it was", "It must be a whole number from 0 to 4294967295.");
  state.seed = seed;
  reset();
  remember();
};
$<HTMLSelectElement>("speed").onchange = (event) => {
  state.speed = Number((event.target as HTMLSelectElement).value);
  tell({ type: "speed", speed: state.speed });
  remember();
};
$<HTMLInputElement>("scrub").oninput = (event) => seek(Number((event.target as HTMLInputElement).value));
addEventListener("keydown", (event) => {
  const at = event.target as HTMLElement;
  if (event.ctrlKey || event.metaKey || event.altKey || at.closest("input, select, button, dialog, .lil-gui")) return;
  if (event.key === " ") {
    event.preventDefault();
    toggle();
  } else if (event.key === ".") stepOnce();
  else if (event.key === "r" || event.key === "R") reset();
});
addEventListener("dragover", (event) => {
  event.preventDefault();
  document.body.classList.add("dropping");
});
addEventListener("dragleave", (event) => {
  if (!event.relatedTarget) document.body.classList.remove("dropping");
});
addEventListener("drop", (event) => {
  event.preventDefault();
  document.body.classList.remove("dropping");
  void open([...(event.dataTransfer?.files ?? [])]);
});
addEventListener("hashchange", () => {
  // A link that somebody put into the address bar.
  void begin();
});

/** For scripts and tests: the numbers of the last frame by name, and what can be asked. */
Object.assign(window, {
  wbqp: {
    field: (name: string) => {
      const found = field(name);
      return found ? [...found] : null;
    },
    about: () => about,
    words: () => words,
    matters: () => lastMatters,
    change,
    whereIs: (name: string) => scene?.whereIs(name) ?? null,
  },
});
