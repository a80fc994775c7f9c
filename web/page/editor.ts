// Scenario and controller as text: TOML with the schema's completion, and the loader's messages at their lines.

import { autocompletion, type CompletionContext, type CompletionResult } from "@codemirror/autocomplete";
import { defaultKeymap, history, historyKeymap, indentWithTab } from "@codemirror/commands";
import { StreamLanguage, defaultHighlightStyle, syntaxHighlighting } from "@codemirror/language";
import { toml } from "@codemirror/legacy-modes/mode/toml";
import { type Diagnostic, lintGutter, setDiagnostics } from "@codemirror/lint";
import { EditorState } from "@codemirror/state";
import { EditorView, drawSelection, highlightActiveLine, keymap, lineNumbers } from "@codemirror/view";
import type { Schema } from "./protocol";

export interface Tab {
  key: "scenario" | "controller" | "robot";
  /** What errors call it, the end of the path. */
  file: string;
  text: string;
}

export class Editor {
  private readonly view: EditorView;
  private states = new Map<string, EditorState>();
  private tabs: Tab[] = [];
  private shown = "";

  constructor(
    host: HTMLElement,
    private readonly bar: HTMLElement,
    private readonly schemas: { controller: Schema; scenario: Schema },
    private readonly run: () => void,
  ) {
    this.view = new EditorView({ parent: host });
  }

  open(tabs: Tab[]): void {
    this.tabs = tabs;
    this.states = new Map(tabs.map((tab) => [tab.key, this.state(tab)]));
    this.bar.replaceChildren(
      ...tabs.map((tab) => {
        const button = document.createElement("button");
        button.role = "tab";
        button.textContent = tab.file;
        button.dataset.tab = tab.key;
        button.onclick = () => this.show(tab.key);
        return button;
      }),
    );
    this.shown = "";
    this.show(tabs[0].key);
  }

  private state(tab: Tab): EditorState {
    const schema = tab.key === "robot" ? null : this.schemas[tab.key];
    return EditorState.create({
      doc: tab.text,
      extensions: [
        lineNumbers(),
        history(),
        drawSelection(),
        highlightActiveLine(),
        lintGutter(),
        StreamLanguage.define(toml),
        syntaxHighlighting(defaultHighlightStyle),
        schema ? autocompletion({ override: [(context) => complete(context, schema)] }) : [],
        EditorView.contentAttributes.of({ "aria-label": `${tab.file}, text` }),
        keymap.of([
          { key: "Mod-Enter", run: () => (this.run(), true) },
          ...defaultKeymap,
          ...historyKeymap,
          indentWithTab,
        ]),
      ],
    });
  }

  private show(key: string): void {
    if (this.shown) this.states.set(this.shown, this.view.state);
    this.shown = key;
    const state = this.states.get(key);
    if (state) this.view.setState(state);
    for (const button of this.bar.querySelectorAll<HTMLButtonElement>("button")) {
      button.setAttribute("aria-selected", String(button.dataset.tab === key));
    }
  }

  text(key: string): string {
    const state = key === this.shown ? this.view.state : this.states.get(key);
    return state?.doc.toString() ?? "";
  }

  /** Replaces a text, as if it had been typed. */
  write(key: string, text: string): void {
    this.show(key);
    this.view.dispatch({ changes: { from: 0, to: this.view.state.doc.length, insert: text } });
  }

  /** The loader's lines, `file:line:column: what`, where they belong; shows the first. */
  mark(text: string): void {
    const found = new Map<string, Diagnostic[]>(this.tabs.map((tab) => [tab.key, []]));
    let first: { key: string; at: number } | null = null;
    for (const line of text.split("\n")) {
      const place = /^(.*?):(\d+):(\d+): (.*)$/.exec(line);
      const tab = place && this.tabs.find((tab) => place[1].endsWith(tab.file));
      if (!place || !tab) continue;
      const doc = (tab.key === this.shown ? this.view.state : this.states.get(tab.key))?.doc;
      if (!doc) continue;
      const row = doc.line(Math.min(Math.max(1, Number(place[2])), doc.lines));
      const from = Math.min(row.from + Number(place[3]) - 1, row.to);
      found.get(tab.key)?.push({ from, to: Math.max(row.to, from), severity: "error", message: place[4] });
      first ??= { key: tab.key, at: from };
    }
    for (const tab of this.tabs) {
      this.show(tab.key);
      this.view.dispatch(setDiagnostics(this.view.state, found.get(tab.key) ?? []));
    }
    this.show(first?.key ?? this.tabs[0].key);
    if (first)
      this.view.dispatch({
        selection: { anchor: first.at },
        effects: EditorView.scrollIntoView(first.at, { y: "center" }),
      });
    this.view.focus();
  }
}

/** The schema of a table: of `[controller]`, of an entry of `[[task]]` with its type. */
function tableAt(context: CompletionContext, root: Schema): { schema: Schema | undefined; isTop: boolean } {
  const { doc } = context.state;
  const at = doc.lineAt(context.pos).number;
  let header: string | null = null;
  let from = 1;
  for (let line = at; line >= 1 && header === null; line--) {
    const found = /^\s*\[\[?([\w.]+)\]\]?/.exec(doc.line(line).text);
    if (found && line < at) [header, from] = [found[1], line + 1];
  }
  if (header === null) return { schema: root, isTop: true };
  let schema: Schema | undefined = root;
  for (const part of header.split(".")) {
    schema = follow(root, schema?.properties?.[part]);
    if (schema?.items) schema = follow(root, schema.items);
  }
  // The rest of the table, for its type.
  let type: string | undefined;
  for (let line = from; line <= doc.lines; line++) {
    const text = doc.line(line).text;
    if (line > at && /^\s*\[/.test(text)) break;
    type ??= /^\s*type\s*=\s*["']([^"']+)/.exec(text)?.[1];
  }
  const kind = header === "solver" || header === "fallback" || header === "robot" ? header : header.split(".")[0];
  const own = type ? root.$defs?.[`${kind}.${type}`] : undefined;
  return { schema: own ?? schema, isTop: false };
}

function follow(root: Schema, schema: Schema | undefined): Schema | undefined {
  const name = schema?.$ref?.replace("#/$defs/", "");
  return name ? root.$defs?.[name] : schema;
}

function kinds(root: Schema, kind: string): string[] {
  const prefix = `${kind}.`;
  return Object.keys(root.$defs ?? {})
    .filter((name) => name.startsWith(prefix))
    .map((name) => name.slice(prefix.length));
}

function complete(context: CompletionContext, root: Schema): CompletionResult | null {
  const line = context.state.doc.lineAt(context.pos);
  const before = line.text.slice(0, context.pos - line.from);
  const header = /^\s*\[\[?([\w.]*)$/.exec(before);
  if (header) {
    const options = Object.entries(root.properties ?? {}).map(([label, about]) => ({
      label,
      info: about.description,
      type: "class",
    }));
    return { from: context.pos - header[1].length, options };
  }
  const value = /^\s*([\w.]+)\s*=\s*["']?([\w.]*)$/.exec(before);
  if (value) {
    const { schema } = tableAt(context, root);
    const about = follow(root, schema?.properties?.[value[1]]);
    const quoted = /["'][\w.]*$/.test(before);
    const wrap = (text: string) => (quoted ? text : `"${text}"`);
    const kind = /^\[\[?(\w+)/.exec(above(context))?.[1] ?? "";
    const words =
      value[1] === "type"
        ? kinds(root, kind)
        : [about, ...(about?.oneOf ?? []), ...(about?.anyOf ?? [])]
            .flatMap((branch) => [...(branch?.enum ?? []), branch?.const])
            .filter((x): x is string => typeof x === "string");
    const from = context.pos - value[2].length;
    if (words.length > 0) return { from, options: words.map((label) => ({ label, apply: wrap(label), type: "enum" })) };
    const standard = about?.default;
    return standard === undefined || standard === null
      ? null
      : { from, options: [{ label: JSON.stringify(standard), detail: "default", type: "constant" }] };
  }
  const key = /^\s*([\w]*)$/.exec(before);
  if (key && (key[1] || context.explicit)) {
    const { schema } = tableAt(context, root);
    const options = Object.entries(schema?.properties ?? {}).map(([label, about]) => ({
      label,
      apply: `${label} = `,
      detail: about["x-unit"],
      info: about.description,
      type: "property",
    }));
    return options.length > 0 ? { from: context.pos - key[1].length, options } : null;
  }
  return null;
}

/** The header of the table that the cursor is in. */
function above(context: CompletionContext): string {
  const { doc } = context.state;
  for (let line = doc.lineAt(context.pos).number; line >= 1; line--) {
    const text = doc.line(line).text.trim();
    if (text.startsWith("[")) return text;
  }
  return "";
}
