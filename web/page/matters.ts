// What matters in this tick: which weights and gains move the command, and which limits hold it. Asked for while it is
// open alone.

import type { Effect, Matters } from "./protocol";

/** Of a weight or a gain, so much more is told; small enough for a derivative. */
const MORE = 0.1;

export class MattersPanel {
  private readonly body: HTMLElement;

  constructor(
    private readonly host: HTMLDetailsElement,
    ask: (on: boolean) => void,
  ) {
    const body = host.querySelector<HTMLElement>(".body");
    if (!body) throw new Error("the panel of what matters has no body");
    this.body = body;
    host.ontoggle = () => ask(host.open);
  }

  show(matters: Matters): void {
    if (!this.host.open) return;
    const parts: HTMLElement[] = [];
    if (matters.refused) parts.push(paragraph(`No derivatives here: ${matters.refused}.`));
    else if (matters.time === null) parts.push(paragraph("From the next tick on: press Play, or take one tick."));
    else {
      const at = `At ${matters.time.toFixed(2)} s, ${100 * MORE} % more of`;
      parts.push(paragraph(at), this.effects(matters.effects));
      if (matters.limits.length > 0) {
        const limits = matters.limits.map(({ name, side }) => `${name}, ${side}`);
        parts.push(list("Limits that hold it", limits, "The optimum would go beyond these if it could."));
      }
      if (matters.notes.length > 0) {
        const notes = matters.notes;
        parts.push(list("Not differentiable", notes, "Where these numbers do not hold as they stand."));
      }
    }
    this.body.replaceChildren(...parts);
  }

  private effects(effects: Effect[]): HTMLElement {
    const largest = Math.max(...effects.map((effect) => effect.effort), Number.MIN_VALUE);
    const found = document.createElement("ol");
    for (const effect of effects) {
      const item = document.createElement("li");
      const [most] = effect.most;
      const name = span("name", `${effect.owner} ${words(effect.key)}`);
      const bar = span("bar", "");
      bar.style.width = `${((100 * effect.effort) / largest).toFixed(1)}%`;
      item.append(name, span("moves", most ? moved(most) : ""), bar);
      const all = effect.most.map(moved).join(", ");
      item.title =
        `${effect.kind === "weight" ? "The weight" : `The gain ${words(effect.key)}`} of ${effect.owner}: ` +
        `${100 * MORE} % more of it changes this tick's optimum by ${all}; all efforts together by ` +
        `${number(MORE * effect.effort)} (N, N·m), which the bar shows. As long as the same limits are active.`;
      found.append(item);
    }
    return found;
  }
}

/** `rotor_3 effort +0.12 N`. */
function moved({ name, slope, unit }: Effect["most"][number]): string {
  const by = MORE * slope;
  return `${words(name)} ${by > 0 ? "+" : "−"}${number(Math.abs(by))} ${unit}`;
}

/** Two digits. */
function number(x: number): string {
  return String(Number(x.toPrecision(2)));
}

function words(key: string): string {
  return key.replace(/_/g, " ");
}

function paragraph(text: string): HTMLElement {
  return Object.assign(document.createElement("p"), { textContent: text });
}

function span(name: string, text: string): HTMLElement {
  return Object.assign(document.createElement("span"), { className: name, textContent: text });
}

function list(title: string, lines: string[], tip: string): HTMLElement {
  const made = document.createElement("ul");
  for (const line of lines) made.append(Object.assign(document.createElement("li"), { textContent: words(line) }));
  const whole = document.createElement("div");
  whole.title = tip;
  whole.append(Object.assign(document.createElement("h3"), { textContent: title }), made);
  return whole;
}
