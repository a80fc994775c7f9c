// Forces, thrusts, errors and times over the last seconds.

import uPlot from "uplot";
import "uplot/dist/uPlot.min.css";
import { COLOURS } from "./scene";
import type { About, Field } from "./protocol";

/** Samples that are kept; then the older half goes. */
const CAPACITY = 24_000;
/** Samples per second that are kept. */
const DENSITY = 250;
/** Ticks over which times are averaged: a browser's clock is coarse. */
const MEAN = 50;

const SERIES = ["#2563c9", "#d9730d", "#1f8a4c", "#8a3ffc", "#c4314b", "#0f8b8d", "#7a5c00", "#5b6672"];

interface Line {
  label: string;
  column: number;
  colour: string;
  dash?: number[];
  width?: number;
}

interface Chart {
  key: string;
  title: string;
  unit: string;
  lines: Line[];
  /** Drawn as dashed lines. */
  limits?: number[];
}

/** Every chart with what it can show: one of its variants at a time. */
interface Panel {
  key: string;
  title: string;
  variants: Chart[];
}

export class Plots {
  private columns: Float64Array[] = [];
  private width = 0;
  private count = 0;
  private every = 1;
  private skipped = 0;
  private panels: { panel: Panel; plot: uPlot; chart: Chart; host: HTMLElement }[] = [];
  private dirty = false;
  private drawn = 0;
  /** Seconds that are seen; all of them if infinite. */
  private readonly window = 12;
  /** For a replay: a time that is marked. */
  cursor: number | null = null;
  all = false;

  constructor(private readonly host: HTMLElement) {
    const draw = () => {
      requestAnimationFrame(draw);
      const now = performance.now();
      if (!this.dirty || now - this.drawn < 60) return;
      this.dirty = false;
      this.drawn = now;
      this.draw();
    };
    draw();
    new ResizeObserver(() => this.fit()).observe(host);
  }

  load(about: About, fields: Field[]): void {
    this.width = fields.reduce((sum, field) => sum + field.count, 0);
    this.columns = Array.from({ length: this.width }, () => new Float64Array(CAPACITY));
    this.count = 0;
    this.skipped = 0;
    this.every = Math.max(1, Math.round(about.rate / DENSITY));
    const at = new Map(fields.map((field) => [field.name, field]));
    const panels = [forces(about, at), efforts(about, at), errors(about, at), times(at)];
    for (const { plot } of this.panels) plot.destroy();
    this.host.replaceChildren();
    this.panels = panels.filter((panel) => panel.variants.length > 0).map((panel) => this.make(panel));
    this.fit();
    this.dirty = true;
  }

  private make(panel: Panel) {
    const host = document.createElement("figure");
    host.className = "plot";
    host.dataset.plot = panel.key;
    const caption = document.createElement("figcaption");
    host.append(caption);
    const chart = panel.variants[0];
    const title = document.createElement("span");
    title.textContent = panel.title;
    caption.append(title);
    const made = { panel, chart, host, plot: null as unknown as uPlot };
    if (panel.variants.length > 1) {
      const choice = document.createElement("select");
      choice.setAttribute("aria-label", `${panel.title}: which`);
      for (const variant of panel.variants) choice.append(new Option(variant.title, variant.key));
      choice.onchange = () => {
        made.chart = panel.variants[choice.selectedIndex];
        made.plot.destroy();
        made.plot = this.plot(made.chart, host);
        this.fit();
        this.dirty = true;
      };
      caption.append(choice);
    } else if (chart.title) {
      const what = document.createElement("small");
      what.textContent = chart.title;
      caption.append(what);
    }
    this.host.append(host);
    made.plot = this.plot(chart, host);
    new ResizeObserver(() => this.fit()).observe(host);
    return made;
  }

  private plot(chart: Chart, host: HTMLElement): uPlot {
    host.querySelector(".key")?.remove();
    host.querySelector(".chart")?.remove();
    const key = document.createElement("div");
    key.className = "key";
    // Many lines are a bundle: names would say less than they cover.
    for (const line of chart.lines.length <= 8 && chart.lines.length > 1 ? chart.lines : []) {
      const name = document.createElement("span");
      name.textContent = line.label;
      name.style.setProperty("--c", line.colour);
      key.append(name);
    }
    const room = document.createElement("div");
    room.className = "chart";
    host.append(key, room);
    const axis = {
      stroke: "#4a5561",
      font: "11px system-ui",
      grid: { stroke: "#e6eaee", width: 1 },
      ticks: { stroke: "#c9d1d9", size: 4 },
    };
    const limits = chart.limits ?? [];
    const options: uPlot.Options = {
      width: 300,
      height: 150,
      legend: { show: false },
      cursor: { drag: { x: false, y: false }, points: { show: false } },
      scales: { x: { time: false }, y: { range: (_, low, high) => range(low, high, limits) } },
      axes: [
        { ...axis, size: 24, gap: 2, label: "t / s", labelSize: 13, labelFont: "11px system-ui", labelGap: 0 },
        {
          ...axis,
          values: (_, ticks) => ticks.map((x) => String(Number(x.toPrecision(4)))),
          size: 50,
          label: chart.unit,
          labelSize: 16,
          labelFont: "11px system-ui",
          labelGap: -2,
        },
      ],
      series: [
        { label: "t" },
        ...chart.lines.map((line) => ({
          label: line.label,
          stroke: line.colour,
          width: line.width ?? 1.5,
          dash: line.dash,
          points: { show: false },
        })),
      ],
      hooks: {
        draw: [
          (u) => {
            const { ctx } = u;
            ctx.save();
            ctx.setLineDash([5, 4]);
            ctx.lineWidth = devicePixelRatio;
            const { left, top, width, height } = u.bbox;
            ctx.strokeStyle = COLOURS.limit;
            for (const limit of limits) {
              const y = u.valToPos(limit, "y", true);
              if (y < top || y > top + height) continue;
              ctx.beginPath();
              ctx.moveTo(left, y);
              ctx.lineTo(left + width, y);
              ctx.stroke();
            }
            if (this.cursor !== null) {
              const x = u.valToPos(this.cursor, "x", true);
              ctx.setLineDash([]);
              ctx.strokeStyle = "#20262d";
              ctx.beginPath();
              ctx.moveTo(x, top);
              ctx.lineTo(x, top + height);
              ctx.stroke();
            }
            ctx.restore();
          },
        ],
      },
    };
    const plot = new uPlot(options, [[], ...chart.lines.map(() => [])] as uPlot.AlignedData, room);
    const canvas = room.querySelector("canvas");
    canvas?.setAttribute("role", "img");
    canvas?.setAttribute("aria-label", `${chart.unit} over time: ${chart.lines.map((line) => line.label).join(", ")}`);
    return plot;
  }

  /** Rows of the history. */
  add(rows: Float64Array): void {
    for (let row = 0; row + this.width <= rows.length; row += this.width) {
      if (++this.skipped < this.every) continue;
      this.skipped = 0;
      if (this.count === CAPACITY) {
        for (const column of this.columns) column.copyWithin(0, CAPACITY / 2);
        this.count = CAPACITY / 2;
      }
      for (let i = 0; i < this.width; i++) this.columns[i][this.count] = rows[row + i];
      // In the first ticks the browser still compiles the module.
      if (this.count < 25) this.columns[1][this.count] = NaN;
      // The clock's times are averaged where they come in.
      const mean = this.columns[1];
      const before = this.count > 0 ? mean[this.count - 1] : NaN;
      if (!Number.isNaN(before)) mean[this.count] = before + (mean[this.count] - before) / MEAN;
      this.count++;
    }
    this.dirty = true;
  }

  refresh(): void {
    this.dirty = true;
  }

  private draw(): void {
    if (this.columns.length === 0) return;
    const time = this.columns[0];
    const end = this.count > 0 ? time[this.count - 1] : 0;
    let first = 0;
    if (!this.all) while (first < this.count && time[first] < end - this.window) first++;
    // More samples than pixels are not seen.
    const step = Math.max(1, Math.floor((this.count - first) / 1600));
    // What is not there is null to the plot.
    const known = (column: Float64Array) =>
      column.some(Number.isNaN) ? Array.from(column, (x) => (Number.isNaN(x) ? null : x)) : column;
    const pick = (column: Float64Array) => {
      if (step === 1) return column.subarray(first, this.count);
      const picked = new Float64Array(Math.ceil((this.count - first) / step));
      for (let i = first, k = 0; i < this.count; i += step) picked[k++] = column[i];
      return picked;
    };
    const t = pick(time);
    for (const { plot, chart } of this.panels) {
      const columns = chart.lines.map((line) => known(pick(this.columns[line.column])));
      plot.setData([t, ...columns] as unknown as uPlot.AlignedData, false);
      const from = this.all ? (t[0] ?? 0) : Math.max(0, end - this.window);
      plot.setScale("x", { min: from, max: Math.max(end, from + (this.all ? 1 : this.window)) });
    }
  }

  private fit(): void {
    for (const { plot, host } of this.panels) {
      const room = host.querySelector(".chart");
      const [width, height] = [room?.clientWidth ?? 0, Math.max(80, room?.clientHeight ?? 0)];
      if (width > 60) plot.setSize({ width, height });
    }
    this.dirty = true;
  }
}

function range(low: number | null, high: number | null, limits: number[]): [number, number] {
  let [from, to] = [low ?? 0, high ?? 1];
  if (limits.length > 0) {
    from = Math.min(from, ...limits);
    to = Math.max(to, ...limits);
  }
  if (!Number.isFinite(from) || !Number.isFinite(to)) return [0, 1];
  const room = Math.max(1e-6, to - from, 1e-3 * Math.abs(to)) * 0.08;
  return [from >= 0 && from < 0.3 * to ? Math.min(0, from) : from - room, to + room];
}

function forces(about: About, at: Map<string, Field>): Panel {
  const variants = about.contacts.flatMap((contact) => {
    const field = at.get(`force/${contact.name}`);
    if (!field) return [];
    const hasSetPoint = about.entries.some((e) => e.type === "contact_force" && e.parameters.contact === contact.name);
    const lines: Line[] = [
      { label: "planned", column: field.at + 1, colour: COLOURS.planned },
      { label: "measured", column: field.at + 2, colour: COLOURS.measured, width: 1 },
      { label: "true", column: field.at + 3, colour: COLOURS.true },
    ];
    if (contact.sensed === false) lines.splice(1, 1);
    if (hasSetPoint) lines.push({ label: "set point", column: field.at, colour: COLOURS.reference, dash: [6, 4] });
    return [{ key: contact.name, title: `contact ${contact.name}`, unit: "force / N", lines }];
  });
  return { key: "force", title: "Normal force", variants };
}

function efforts(about: About, at: Map<string, Field>): Panel {
  const field = at.get("efforts");
  if (!field) return { key: "effort", title: "Efforts", variants: [] };
  const group = (isRotor: boolean): Chart[] => {
    const some = about.actuators.map((a, i) => ({ a, i })).filter(({ a }) => (a.rotor !== null) === isRotor);
    if (some.length === 0) return [];
    const lines = some.map(({ a, i }, k) => ({
      label: a.name.replace(/_/g, " ").replace(/^rotor /, ""),
      column: field.at + i,
      colour: SERIES[k % SERIES.length],
      width: some.length > 8 ? 1 : 1.5,
    }));
    const limits = isRotor
      ? [...new Set(some.flatMap(({ a }) => [a.lower, a.upper]).filter((x): x is number => x !== null))]
      : [];
    return [
      {
        key: isRotor ? "thrusts" : "joints",
        title: isRotor ? "rotors" : "joints",
        unit: isRotor ? "thrust / N" : "torque / N·m",
        lines,
        limits,
      },
    ];
  };
  const variants = [...group(true), ...group(false)];
  return { key: "effort", title: variants[0]?.key === "thrusts" ? "Thrusts" : "Torques", variants };
}

function errors(about: About, at: Map<string, Field>): Panel {
  const units = new Map<string, Line[]>();
  for (const entry of about.entries) {
    const field = at.get(`error/${entry.name}`);
    if (!field || !entry.error_unit) continue;
    const lines = units.get(entry.error_unit) ?? [];
    lines.push({
      label: entry.name.replace(/_/g, " "),
      column: field.at,
      colour: SERIES[lines.length % SERIES.length],
    });
    units.set(entry.error_unit, lines);
  }
  const variants = [...units].map(([unit, lines]) => ({
    key: unit,
    title: `in ${unit}`,
    unit: `|error| / ${unit}`,
    lines,
  }));
  return { key: "error", title: "Task errors", variants };
}

function times(at: Map<string, Field>): Panel {
  const field = at.get("tick_us");
  const lines = field ? [{ label: "tick", column: field.at, colour: SERIES[5] }] : [];
  const variants = lines.length > 0 ? [{ key: "time", title: `mean of ${MEAN}`, unit: "time / µs", lines }] : [];
  return { key: "time", title: "Tick time", variants };
}
