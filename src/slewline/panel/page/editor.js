/**
 * The editor: a program with the findings of the assembler in place; assemble, load, run; the examples.
 */

import { button, calmly, choices, h, put, say, select } from "./dom.js";
import { grouped } from "./format.js";

/** @typedef {import("./link.js").Link} Link */
/** @typedef {{line: number, column: number, length: number, severity: string, says: string, remedy?: string}} Problem */
/** @typedef {{line: number, address: number, bytes: string, text: string}} Row */

const CALM_MS = 300; // after the last key, the program is assembled
const LONGEST = 60_000; // characters of a program: a request is shorter than 64 KiB
const STARTS = /^(run|execute|start)\b.*\bprogram\b/i; // a manual's description of the command that runs the stored program

/**
 * Show the editor.
 * @param {Link} link
 * @param {Map<string, any>} sheets of the chips, by name
 * @param {HTMLElement} root
 * @param {(error: Error) => void} fail
 * @returns {{update: (view: any) => void, close: () => void}}
 */
export function editor(link, sheets, root, fail) {
  /** @type {Problem[]} */
  let problems = [];
  /** @type {Map<number, Row>} */
  let rows = new Map();
  let number = 0; // of the last request to the assembler
  let name = "program.txt";

  const chip = select("Chip", {}, { change: chipChanged });
  const example = select("Example", { "": "Examples…" }, { change: open });
  const file = h("input", { type: "file", class: "unseen", tabindex: -1, "aria-label": "File to open", change: read });
  const gutter = h("div", { class: "gutter", "aria-hidden": "true" });
  const marks = h("pre", { class: "marks", "aria-hidden": "true" });
  const text = h("textarea", {
    "aria-label": "Program", spellcheck: "false", autocomplete: "off", autocapitalize: "off", wrap: "off",
    input: changed, scroll: follow, placeholder: "A program: one command per line, as a host sends it.",
  });
  const state = h("p", { class: "quiet", role: "status", "aria-live": "polite" });
  const list = h("ul", { class: "plain problems" });
  root.append(
    h("div", { class: "row" }, chip, example, h("span", { class: "grow" }),
      button("Open…", () => file.click(), { "data-writes": null }), button("Save", save, { "data-writes": null }), file),
    h("div", { class: "editor" }, gutter, h("div", { class: "editor-text" }, marks, text)),
    list,
    h("div", { class: "row" }, state, h("span", { class: "grow" }),
      button("Assemble", () => assemble(true), { "data-writes": null }), button("Load", load), button("Run", run, { class: "primary" })),
  );

  async function open() {
    const chosen = example.value;
    if (!chosen) return;
    try {
      const reply = await link.request({ do: "example", name: chosen });
      const part = chosen.split(".").at(-1);
      const fits = [...sheets].find(([, sheet]) => sheet.part.toLowerCase() === part);
      if (fits) chip.value = fits[0];
      fill(reply.text, chosen.split("/").at(-1) ?? chosen);
    } catch (error) {
      fail(/** @type {Error} */ (error));
    }
    example.value = "";
  }

  async function read() {
    const chosen = file.files?.[0];
    if (!chosen) return;
    if (chosen.size > LONGEST) fail(new Error(`${chosen.name} has more than ${grouped(LONGEST)} bytes`));
    else fill(await chosen.text(), chosen.name);
    file.value = "";
  }

  /**
   * @param {string} program
   * @param {string} from
   */
  function fill(program, from) {
    name = from;
    text.value = program;
    text.scrollTop = 0;
    rows = new Map();
    problems = [];
    draw();
    assemble(false);
  }

  function save() {
    const link = h("a", { href: URL.createObjectURL(new Blob([text.value], { type: "text/plain" })), download: name });
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  }

  const soon = calmly(() => assemble(false), CALM_MS);

  function changed() {
    draw();
    soon();
  }

  /** @param {boolean} asked */
  async function assemble(asked) {
    const mine = ++number;
    if (!text.value.trim() || !chip.value) {
      problems = [];
      rows = new Map();
      say(state, asked ? "There is nothing to assemble." : "");
      draw();
      return true;
    }
    try {
      const reply = await link.request({ do: "assemble", chip: chip.value, text: text.value });
      if (mine !== number) return false;
      problems = reply.problems ?? [];
      rows = new Map((reply.rows ?? []).map((/** @type {Row} */ row) => [row.line, row]));
      const wrong = problems.length ? `${problems.length} ${problems.length > 1 ? "problems" : "problem"}` : "no problems";
      say(state, `${grouped(reply.bytes ?? 0)} ${reply.bytes === 1 ? "byte" : "bytes"}, ${wrong}`);
    } catch (error) {
      if (mine !== number) return false;
      problems = [];
      rows = new Map();
      say(state, /** @type {Error} */ (error).message);
    }
    draw();
    return !problems.some((one) => one.severity === "error");
  }

  async function load() {
    if (!text.value.trim()) return fail(new Error("There is no program: write one, open a file, or choose an example."));
    if (!(await assemble(true))) return fail(new Error("The program has errors; they are marked in the editor."));
    try {
      await link.request({ do: "send", chip: chip.value, text: text.value });
      say(state, `Sent to ${chip.value}.`);
    } catch (error) {
      say(state, "Not sent.");
      fail(/** @type {Error} */ (error));
      return false;
    }
    return true;
  }

  async function run() {
    if (!(await load())) return;
    const starts = sheets.get(chip.value)?.commands?.find((/** @type {any} */ one) => STARTS.test(one.says ?? ""));
    const last = text.value.split("\n").map((line) => line.replace(/;.*/, "").trim()).filter(Boolean).at(-1) ?? "";
    try {
      if (starts && !last.endsWith(starts.form) && rows.size) {
        await link.request({ do: "send", chip: chip.value, text: starts.form });
      }
      if (link.view.pace?.paused) await link.request({ do: "go" });
    } catch (error) {
      fail(/** @type {Error} */ (error));
    }
  }

  function chipChanged() {
    assemble(false);
  }

  function draw() {
    const lines = text.value.split("\n");
    /** @type {Map<number, Problem[]>} */
    const byLine = new Map();
    for (const one of problems) byLine.set(one.line, [...(byLine.get(one.line) ?? []), one]);
    gutter.replaceChildren(
      ...lines.map((_line, index) => {
        const row = rows.get(index + 1);
        const wrong = byLine.get(index + 1);
        return h("div", { class: wrong ? `gutter-line ${worst(wrong)}` : "gutter-line", title: row?.bytes || null },
          h("span", { class: "line-bytes" }, row?.bytes ?? ""), h("span", {}, String(index + 1)));
      }),
    );
    marks.replaceChildren();
    lines.forEach((line, index) => {
      let at = 0;
      for (const one of (byLine.get(index + 1) ?? []).sort((a, b) => a.column - b.column)) {
        const start = Math.max(at, one.column - 1);
        const end = Math.max(start + 1, start + (one.length || line.length));
        put(marks, line.slice(at, start), h("mark", { class: one.severity }, line.slice(start, end) || " "));
        at = Math.min(end, line.length);
      }
      put(marks, `${line.slice(at)}\n`);
    });
    list.replaceChildren(
      ...problems.slice(0, 50).map((one) =>
        h("li", { class: one.severity },
          button(`${one.line}:${one.column}`, () => go(one), { class: "bare place", "data-writes": null }),
          h("span", {}, one.says, one.remedy && h("span", { class: "quiet" }, ` ${one.remedy}`)))),
    );
    list.hidden = !problems.length;
    follow();
  }

  /** @param {Problem} one */
  function go(one) {
    const start = text.value.split("\n").slice(0, one.line - 1).reduce((sum, line) => sum + line.length + 1, 0);
    text.focus();
    text.setSelectionRange(start + one.column - 1, start + one.column - 1 + one.length);
  }

  function follow() {
    gutter.scrollTop = text.scrollTop;
    marks.scrollTop = text.scrollTop;
    marks.scrollLeft = text.scrollLeft;
  }

  link.request({ do: "examples" }).then(
    (reply) => {
      const fitting = new Set([...sheets.values()].map((sheet) => sheet.part.toLowerCase()));
      const all = reply.examples.filter((/** @type {any} */ one) => !one.part || fitting.has(one.part.toLowerCase()));
      choices(example, { "": "Examples…", ...Object.fromEntries(
        all.map((/** @type {any} */ one) => [one.name, exampleName(one)])) });
    },
    () => { example.hidden = true; },
  );
  draw();

  let names = "";
  return {
    update() {
      const all = [...sheets.keys()];
      if (all.join() === names) return;
      names = all.join();
      choices(chip, Object.fromEntries(all.map((one) => [one, `${one} (${sheets.get(one).part})`])));
    },
    close() {
      number++;
      root.replaceChildren();
    },
  };
}

/**
 * Return the list entry of an example: the name of its file, and its title.
 * @param {{name: string, title: string}} one
 * @returns {string}
 */
function exampleName(one) {
  const name = one.name.split("/").at(-1) ?? one.name;
  return one.title ? `${name}: ${one.title.replace(/\.$/, "")}` : name;
}

/**
 * Return the severity of the worst of some problems.
 * @param {Problem[]} problems
 * @returns {string}
 */
function worst(problems) {
  return problems.some((one) => one.severity === "error") ? "error" : "warning";
}
