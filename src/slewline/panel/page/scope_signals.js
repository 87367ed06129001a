/**
 * The list of signals for the scope: the pins of each chip and part, and the quantities.
 */

import { field, h } from "./dom.js";

const FIRST = ["step", "direction", "slewing", "moving", "motion_complete", "running"]; // roles shown initially
const FIRST_PINS = 3;
export const MOST = 32; // signals at a time

export class Signals {
  /** @param {(chosen: string[]) => void} changed */
  constructor(changed) {
    this.changed = changed;
    /** In the order in which they were chosen. @type {string[]} */
    this.chosen = [];
    /** @type {string[]} */
    this.quantities = [];
    /** @type {string[]} */
    this.pins = [];
    /** @type {string[]} */
    this.owners = [];
    this.filter = field("Filter the signals", { type: "search", placeholder: "filter", input: () => this.sift() });
    this.lists = h("div", { class: "signal-lists" });
    this.count = h("span", { class: "signal-count" });
    const summary = h("summary", {}, "Signals ", this.count);
    const sheet = h("div", { class: "scope-popover" }, this.filter, this.lists);
    this.element = h("details", { class: "scope-menu" }, summary, sheet);
    this.element.addEventListener("keydown", (event) => {
      if (event.key !== "Escape") return;
      this.element.open = false;
      summary.focus();
    });
    document.addEventListener("pointerdown", this.outside);
  }

  /** @param {PointerEvent} event */
  outside = (event) => {
    if (event.target instanceof Node && !this.element.contains(event.target)) this.element.open = false;
  };

  close() {
    document.removeEventListener("pointerdown", this.outside);
  }

  /**
   * Offer the present signals; the selection is kept if it still exists.
   * @param {{pins: Record<string, string[]>, quantities: string[]}} signals
   */
  offer(signals) {
    this.quantities = signals.quantities ?? [];
    this.owners = Object.keys(signals.pins ?? {});
    this.pins = this.owners.flatMap((owner) => signals.pins[owner].map((pin) => `${owner}.${pin}`));
    const there = new Set([...this.quantities, ...this.pins]);
    this.chosen = this.chosen.filter((name) => there.has(name));
    this.lists.replaceChildren();
    if (this.quantities.length) this.lists.append(this.list("quantities", this.quantities, ""));
    for (const owner of this.owners) this.lists.append(this.list(owner, signals.pins[owner], `${owner}.`));
    this.sift();
    this.tell();
  }

  /**
   * @param {string} title
   * @param {string[]} names
   * @param {string} prefix
   * @returns {HTMLElement}
   */
  list(title, names, prefix) {
    const boxes = names.map((name) => {
      const signal = prefix + name;
      const box = h("input", { type: "checkbox", value: signal, "aria-label": signal, checked: this.chosen.includes(signal) });
      box.addEventListener("change", () => this.choose(signal, box.checked));
      return h("label", { "data-signal": signal.toLowerCase() }, box, name);
    });
    return h("fieldset", {}, h("legend", {}, title), ...boxes);
  }

  /** Hide signals that do not match the filter. */
  sift() {
    const text = this.filter.value.trim().toLowerCase();
    for (const label of this.lists.querySelectorAll("label")) label.hidden = !label.dataset.signal?.includes(text);
    for (const set of this.lists.querySelectorAll("fieldset")) set.hidden = !set.querySelector("label:not([hidden])");
  }

  /**
   * @param {string} signal
   * @param {boolean} shown
   */
  choose(signal, shown) {
    this.chosen = this.chosen.filter((name) => name !== signal);
    if (shown) this.chosen = [...this.chosen, signal].slice(-MOST);
    this.tell();
    this.changed(this.chosen);
  }

  /** @param {string[]} names */
  show(names) {
    this.chosen = names;
    for (const box of this.lists.querySelectorAll("input")) box.checked = names.includes(box.value);
    this.tell();
    this.changed(names);
  }

  tell() {
    this.count.textContent = String(this.chosen.length);
  }
}

/**
 * Return the signals shown before the user selects any: the pins of a chip that show its motion, and its quantities.
 * @param {string} chip
 * @param {Record<string, any>[]} pins of its sheet
 * @param {string[]} quantities
 * @returns {string[]}
 */
export function firstSignals(chip, pins, quantities) {
  const ranked = FIRST.map((role) => pins.find((pin) => pin.role === role)).filter((pin) => pin !== undefined);
  const own = quantities.filter((name) => name.startsWith(`${chip} `) || name.startsWith(`${chip}.`)).sort((a, b) => Number(/position/.test(a)) - Number(/position/.test(b)));
  return [...ranked.slice(0, FIRST_PINS).map((pin) => `${chip}.${pin.name}`), ...own.slice(0, 2)];
}
