/**
 * The trigger of the scope: its settings, and the request for them.
 */

import { choices, field, h, select } from "./dom.js";
import { control } from "./elements.js";

/** @typedef {Record<string, any>} Data */

const KINDS = { none: "off", edge: "edge", level: "level", value: "position or value", finding: "finding" };
const EDGES = { rises: "rises", falls: "falls", any: "rises or falls" };
const LEVELS = { 1: "is high", 0: "is low" };
const SLOPES = { rises: "rises through", falls: "falls through" };
const MODES = { auto: "or roll", normal: "and wait" };

export class Trigger {
  /**
   * @param {() => void} changed
   * @param {(last: boolean) => void} seek goes to the previous or the next one
   */
  constructor(changed, seek) {
    const listener = { change: () => (this.arrange(), changed()) };
    this.kind = select("Trigger on", KINDS, listener);
    this.pin = select("Pin", {}, listener);
    this.edge = select("Edge", EDGES, listener);
    this.level = select("Level", LEVELS, listener);
    this.quantity = select("Quantity", {}, listener);
    this.slope = select("Slope", SLOPES, listener);
    this.value = field("Value", { type: "number", step: "any", value: "0", ...listener });
    this.chip = select("Findings of", { "": "anything" }, listener);
    this.mode = select("Until the trigger occurs", MODES, listener);
    this.back = control("\u2039 previous", () => seek(true), { "aria-label": "Previous trigger" });
    this.forth = control("next \u203a", () => seek(false), { "aria-label": "Next trigger" });
    this.state = h("span", { class: "trigger-state", role: "status" });
    this.element = h(
      "div", { class: "trigger", role: "group", "aria-label": "Trigger" },
      h("label", {}, "trigger on ", this.kind), this.pin, this.edge, this.level, this.quantity, this.slope, this.value,
      this.chip, this.mode, this.back, this.forth, this.state,
    ); // prettier-ignore
    this.arrange();
  }

  /** @returns {boolean} */
  get on() {
    return this.kind.value !== "none";
  }

  /** Show the fields of the selected kind of trigger. */
  arrange() {
    const kind = this.kind.value;
    this.pin.hidden = kind !== "edge" && kind !== "level";
    this.edge.hidden = kind !== "edge";
    this.level.hidden = kind !== "level";
    for (const one of [this.quantity, this.slope, this.value]) one.hidden = kind !== "value";
    this.chip.hidden = kind !== "finding";
    for (const one of [this.mode, this.back, this.forth, this.state]) one.hidden = kind === "none";
  }

  /**
   * Offer other signals.
   * @param {string[]} pins
   * @param {string[]} quantities
   * @param {string[]} owners
   */
  offer(pins, quantities, owners) {
    const named = (/** @type {string[]} */ names) => Object.fromEntries(names.map((name) => [name, name]));
    choices(this.pin, named(pins));
    choices(this.quantity, named(quantities));
    choices(this.chip, { "": "anything", ...named(owners) });
  }

  /**
   * Return the search for `find`, or null.  A level lasts, so the search is for the edge at its end.
   * @returns {Data | null}
   */
  sought() {
    const kind = this.kind.value;
    if (kind === "edge" && this.pin.value) return { pin: this.pin.value, edge: this.edge.value };
    if (kind === "level" && this.pin.value) return { pin: this.pin.value, edge: this.level.value === "1" ? "falls" : "rises" };
    if (kind === "value" && this.quantity.value) {
      return { quantity: this.quantity.value, value: Number(this.value.value) || 0, slope: this.slope.value };
    }
    return kind === "finding" ? { finding: this.chip.value } : null;
  }

  /**
   * Return whether the pin now has the awaited level.
   * @param {Data} view
   * @returns {boolean}
   */
  holds(view) {
    if (this.kind.value !== "level") return false;
    const at = this.pin.value.indexOf(".");
    const [owner, pin] = [this.pin.value.slice(0, at), this.pin.value.slice(at + 1)];
    const levels = view.chips?.[owner]?.levels ?? view.parts?.[owner]?.levels;
    return String(levels?.[pin]) === this.level.value;
  }
}
