// Sliders and switches for everything that can be changed, made from the registry's JSON Schema.

import GUI, { type Controller } from "lil-gui";
import type { About, Change, Entry, Schema } from "./protocol";

export interface Asked {
  /** Of the running controller, from the next tick on. */
  change(change: Change): void;
  /** In a file, from the next start on: a line `set.…` or `change.…`. */
  vary(key: string, value: unknown): void;
}

/** Keys that an entry has beside its plug-in's own. */
const COMMON = new Set(["type", "name", "weight", "active", "transition", "hardness"]);

export class Panel {
  private gui: GUI | null = null;

  constructor(
    private readonly host: HTMLElement,
    private readonly schemas: { controller: Schema; scenario: Schema },
    private readonly asked: Asked,
  ) {}

  load(about: About, varied: Map<string, unknown>): void {
    this.gui?.destroy();
    const gui = new GUI({ container: this.host, title: "Parameters", width: undefined });
    gui.domElement.classList.add("panel");
    this.gui = gui;
    const points = gui.addFolder("Set points");
    const contacts = gui.addFolder("Contacts");
    const tasks = gui.addFolder("Tasks");
    const constraints = gui.addFolder("Constraints");
    const start = gui.addFolder("Plant and contacts, from the next reset on");
    for (const entry of about.entries) {
      this.entry(entry.kind === "task" ? tasks : constraints, entry);
      if (entry.reference) this.setPoint(points, entry);
    }
    for (const contact of about.contacts) this.contact(contacts, contact.name, contact.active === true);
    this.plant(start, about, varied);
    tasks.close();
    constraints.close();
    start.close();
    if (points.controllers.length + points.folders.length === 0) points.destroy();
    if (about.contacts.length === 0) contacts.destroy();
    if (about.contacts.length > 1) contacts.close();
    if (points.folders.length > 3) for (const folder of points.folders) folder.close();
  }

  private schemaOf(entry: Entry): Schema | undefined {
    return this.schemas.controller.$defs?.[`${entry.kind}.${entry.type}`];
  }

  private entry(gui: GUI, entry: Entry): void {
    const folder = gui.addFolder(`${entry.name}`);
    folder.domElement.title = entry.type;
    folder.close();
    const schema = this.schemaOf(entry);
    const state = { on: entry.active };
    const toggle = folder.add(state, "on").name("on");
    toggle.onChange((on: boolean) => this.asked.change({ do: "entry", of: entry.name, on }));
    label(toggle, `${entry.name}: on`);
    const isSoft = entry.kind === "task" || entry.hardness !== "hard";
    if (isSoft) {
      this.numbers(
        folder,
        "weight",
        entry.weight,
        { minimum: 0, description: schema?.properties?.weight?.description },
        entry,
        (value) => this.asked.change({ do: "weight", of: entry.name, value: value as number | number[] }),
      );
    }
    for (const [key, about] of Object.entries(schema?.properties ?? {})) {
      if (COMMON.has(key)) continue;
      this.key(folder, entry, key, about, entry.parameters[key]);
    }
  }

  /** A key of a plug-in, by what its schema says it is. */
  private key(gui: GUI, entry: Entry, key: string, about: Schema, value: unknown): void {
    const set = (value: unknown) => this.asked.change({ do: "set", of: entry.name, keys: { [key]: value } });
    if (about["x-plugin"] || about.$ref || isReference(value)) return;
    const options = choices(about);
    if (
      typeof value === "number" ||
      (Array.isArray(value) && value.length > 0 && value.every((x) => typeof x === "number"))
    ) {
      this.numbers(gui, key, value as number | number[], about, entry, set);
    } else if (typeof value === "boolean") {
      const made = gui
        .add({ [key]: value }, key)
        .name(words(key))
        .onChange(set);
      label(made, `${entry.name}: ${words(key)}`, about.description);
    } else if (typeof value === "string" && options.length > 1) {
      const made = gui
        .add({ [key]: value }, key, options)
        .name(words(key))
        .onChange(set);
      label(made, `${entry.name}: ${words(key)}`, about.description);
    }
  }

  /** A slider per number; the reach is the schema's, or four times what it is now. */
  private numbers(
    gui: GUI,
    key: string,
    value: number | number[],
    about: Schema,
    entry: Entry,
    done: (value: number | number[]) => void,
  ): void {
    const unit = about["x-unit"] ? ` / ${about["x-unit"]}` : "";
    const list = Array.isArray(value) ? [...value] : [value];
    const rows = entry.rows ?? [];
    const state: Record<string, number> = {};
    list.forEach((x, i) => {
      const row = list.length > 1 ? ` ${rows.length === list.length ? rows[i].label : i + 1}` : "";
      const name = `${words(key)}${row}${unit}`;
      state[name] = x;
      const integer = about.type === "integer";
      const [least, most] = reach(x, limit(about, "minimum"), limit(about, "maximum"));
      const made = gui.add(state, name, least, most, integer ? 1 : step(most - least));
      made.onChange((now: number) => {
        list[i] = now;
        done(Array.isArray(value) ? [...list] : now);
      });
      label(made, `${entry.name}: ${name}`, about.description);
    });
  }

  /** What a task follows, as numbers: it goes there in a second. */
  private setPoint(gui: GUI, entry: Entry): void {
    const reference = entry.reference;
    if (!reference) return;
    const names =
      entry.rows?.length === reference.value.length && reference.space === "vector"
        ? entry.rows.map((row) => row.label)
        : reference.space === "rotation"
          ? ["roll", "pitch", "yaw"]
          : reference.value.map((_, i) => `${i + 1}`);
    const unit = entry.error_unit ?? "";
    const folder = gui.addFolder(entry.name);
    const values = reference.value.map((x) => Number(x.toFixed(4)));
    if (values.length > 6) folder.close();
    if (entry.type === "contact_force") names[0] = "normal";
    values.forEach((x, i) => {
      const name = `${names[i]} / ${unit}`;
      const state = { [name]: x };
      const wide = unit === "N" ? Math.max(10, 3 * Math.abs(x)) : unit === "rad" ? 0.8 : 0.5;
      const [least, most] = unit === "N" && x >= 0 ? [0, wide] : [x - wide, x + wide];
      const made = folder.add(state, name, least, most, step(most - least));
      made.onChange((now: number) => {
        values[i] = now;
        this.asked.change({
          do: "follow",
          of: entry.name,
          reference: { type: "min_jerk", to: [...values], duration: 1 },
        });
      });
      label(made, `${entry.name}: set point ${name}`, "The task goes there within a second.");
    });
  }

  private contact(gui: GUI, name: string, active: boolean): void {
    const state = { [name]: active };
    const made = gui.add(state, name).name(`${name} on`);
    made.onChange((on: boolean) => this.asked.change({ do: "contact", of: name, on }));
    label(made, `contact ${name}: on`, "A detector of the scenario may switch it as well.");
  }

  /** What only a new start can change: contacts, hardness, the plant's differences. */
  private plant(gui: GUI, about: About, varied: Map<string, unknown>): void {
    const mismatch = resolve(this.schemas.scenario, this.schemas.scenario.properties?.plant)?.properties?.mismatch;
    const keys = resolve(this.schemas.scenario, mismatch)?.properties ?? {};
    for (const [key, about] of Object.entries(keys)) {
      const value = about.default;
      if (typeof value !== "number") continue;
      const path = `change.plant.mismatch.${key}`;
      const name = `plant: ${words(key)}`;
      const state = { [name]: Number(varied.get(path) ?? value) };
      const made = gui.add(state, name, 0.5, 1.5, 0.01);
      made.onFinishChange((now: number) => this.asked.vary(path, now));
      label(made, name, about.description);
    }
    const list = this.schemas.controller.properties?.contact?.items;
    const contactKeys = list?.properties ?? {};
    for (const contact of about.contacts) {
      const folder = gui.addFolder(`contact ${contact.name}`);
      folder.close();
      for (const [key, about] of Object.entries(contactKeys)) {
        const value = contact[key];
        if (typeof value !== "number") continue;
        const path = `set.contact.${contact.name}.${key}`;
        const unit = about["x-unit"] ? ` / ${about["x-unit"]}` : "";
        const name = words(key) + unit;
        const [least, most] = reach(value, limit(about, "minimum") ?? 0, limit(about, "maximum"));
        const made = folder.add({ [name]: value }, name, least, Math.max(most, 1), step(most - least));
        made.onFinishChange((now: number) => this.asked.vary(path, now));
        label(made, `contact ${contact.name}: ${name}`, about.description);
      }
    }
    for (const entry of about.entries) {
      if (entry.kind !== "constraint" || typeof entry.hardness !== "string") continue;
      const name = `${entry.name}: hardness`;
      const made = gui.add({ [name]: entry.hardness }, name, ["hard", "soft"]);
      made.onChange((now: string) => this.asked.vary(`set.constraint.${entry.name}.hardness`, now));
      label(made, name, "Whether its rows must hold or are paid for.");
    }
  }
}

function isReference(value: unknown): boolean {
  return typeof value === "object" && value !== null && "type" in value;
}

/** A schema with its reference followed. */
function resolve(root: Schema, schema: Schema | undefined): Schema | undefined {
  const name = schema?.$ref?.replace("#/$defs/", "");
  if (name) return root.$defs?.[name];
  return schema?.allOf?.length === 1 ? resolve(root, schema.allOf[0]) : schema;
}

function choices(about: Schema): string[] {
  const branches = [about, ...(about.oneOf ?? []), ...(about.anyOf ?? [])];
  return branches
    .flatMap((branch) => [...(branch.enum ?? []), branch.const])
    .filter((x): x is string => typeof x === "string");
}

/** A limit of a number, also where the schema has a choice of number and list. */
function limit(about: Schema, key: "minimum" | "maximum"): number | undefined {
  for (const branch of [about, ...(about.anyOf ?? []), ...(about.oneOf ?? [])]) {
    if (typeof branch[key] === "number") return branch[key];
  }
  return undefined;
}

function reach(x: number, least: number | undefined, most: number | undefined): [number, number] {
  const far = x === 0 ? 10 : 4 * Math.abs(x);
  const nice = 10 ** Math.floor(Math.log10(far));
  const up = Math.ceil(far / nice) * nice;
  return [least ?? (x < 0 ? -up : 0), most ?? up];
}

function step(width: number): number {
  return 10 ** Math.floor(Math.log10(Math.max(width, 1e-9) / 200));
}

function words(key: string): string {
  return key.replace(/_/g, " ");
}

/** For screen readers and pointers that rest. */
function label(controller: Controller, name: string, description?: string): void {
  for (const input of controller.domElement.querySelectorAll("input, select, button"))
    input.setAttribute("aria-label", name);
  if (description) controller.domElement.title = description;
}
