/**
 * Readings at the cursors: instants, the time between them, and the level or value of every signal.
 */

import { h, say } from "./dom.js";
import { instantText, rateText, timeText, valueText } from "./units.js";
import { levelAt, valueAt } from "./window_data.js";

/** @typedef {import("./window_data.js").Trace} Trace */

const LEVELS = new Map([
  ["1", "high"],
  ["0", "low"],
  ["-", "floats"],
  ["x", "changes"],
  ["", "\u2013"],
]);

/**
 * Return the difference of two values, without rounding errors.
 * @param {number} a
 * @param {number} b
 * @returns {number}
 */
function apart(a, b) {
  return Math.abs(b - a) < 1e-9 * Math.max(Math.abs(a), Math.abs(b)) ? 0 : b - a;
}

export class Readings {
  constructor() {
    /** Replies to queries at the instant of a cursor only. @type {({ps: number, traces: Map<string, Trace>} | null)[]} */
    this.exact = [null, null];
    const head = h("tr", {}, ...["", "A", "B", "B \u2212 A"].map((text) => h("th", { scope: "col" }, text)));
    this.body = h("tbody");
    this.hint = h("p", { class: "scope-hint" }, "Click or tap to set a cursor; drag, turn the wheel or use two fingers to move the window.");
    this.table = h("table", { class: "scope-readings", "aria-label": "Readings at the cursors" }, h("thead", {}, head), this.body);
    this.table.hidden = true;
    this.element = h("div", { class: "scope-below" }, this.table, this.hint);
    /** @type {Map<string, HTMLElement[]>} */
    this.rows = new Map();
  }

  /**
   * @param {(number | null)[]} cursors
   * @param {string[]} signals
   * @param {Map<string, Trace>} traces
   * @param {number} resolution ps of a point of the picture
   */
  show(cursors, signals, traces, resolution) {
    this.table.hidden = cursors.every((ps) => ps === null);
    this.hint.hidden = !this.table.hidden;
    if (this.table.hidden) return;
    const wanted = ["time", ...signals];
    if (wanted.join("\n") !== [...this.rows.keys()].join("\n")) this.build(wanted);
    const [a, b] = cursors;
    const both = a !== null && b !== null;
    const instants = cursors.map((ps) => (ps === null ? "\u2013" : instantText(ps, resolution / 10)));
    this.fill("time", instants, both ? `${timeText(b - a, 6)}\n${b === a ? "" : rateText(b - a)}` : "");
    for (const name of signals) {
      const found = cursors.map((ps, n) => (ps === null ? null : this.at(name, ps, n, traces)));
      const numbers = found.map((one) => (typeof one === "number" ? one : null));
      const difference = numbers[0] !== null && numbers[1] !== null ? apart(numbers[0], numbers[1]) : null;
      const unit = this.unit(name, traces);
      const texts = found.map((one) => (typeof one === "string" ? (LEVELS.get(one) ?? "") : valueText(one, unit)));
      this.fill(name, texts, difference === null ? "" : valueText(difference, unit));
    }
  }

  /**
   * @param {string} name
   * @param {number} ps
   * @param {number} n
   * @param {Map<string, Trace>} traces
   * @returns {string | number | null}
   */
  at(name, ps, n, traces) {
    const exact = this.exact[n];
    const trace = (exact?.ps === ps ? exact.traces.get(name) : undefined) ?? traces.get(name);
    if (!trace) return null;
    return trace.kind === "pin" ? levelAt(trace, ps) : valueAt(trace, ps);
  }

  /**
   * @param {string} name
   * @param {Map<string, Trace>} traces
   * @returns {string}
   */
  unit(name, traces) {
    const trace = traces.get(name);
    return trace?.kind === "quantity" ? trace.unit : "";
  }

  /** @param {string[]} names */
  build(names) {
    this.rows.clear();
    this.body.replaceChildren();
    for (const name of names) {
      const cells = [h("td"), h("td"), h("td")];
      this.rows.set(name, cells);
      this.body.append(h("tr", {}, h("th", { scope: "row" }, name), ...cells));
    }
  }

  /**
   * @param {string} name
   * @param {string[]} texts
   * @param {string} difference
   */
  fill(name, texts, difference) {
    const cells = this.rows.get(name) ?? [];
    [...texts, difference].forEach((text, n) => say(cells[n], text));
  }
}
