/**
 * The front panel of a machine: displays, thumbwheels, a jog switch, contacts, lamps, counters, and buttons for all
 * other manual operations.  Each is an element with `take`, which receives the state of its part from a view.
 */

import { button, h, say } from "./dom.js";
import { set, svg } from "./elements.js";
import { onHold } from "./hold.js";
import { digitsOf } from "./units.js";

/** @typedef {Record<string, any>} Shows */
/** @typedef {(verb: string, ...args: (number | string)[]) => void} Act */

const FLASH = "display-flash";
const TRUST_MS = 1000; // after a click, the requested state is shown, even if an older view differs

/** A display: a row of lit characters, or a liquid crystal with several rows. */
export class Display {
  /** @param {string} name */
  constructor(name) {
    this.rows = h("div", { class: "display", role: "img" });
    this.element = this.rows;
    this.name = name;
    this.drawn = "";
  }

  /** @param {Shows} shows */
  take(shows) {
    /** @type {string[]} */
    const text = Array.isArray(shows.text) ? shows.text : [String(shows.text)];
    const flashing = new Set(shows.flashing ?? []);
    const drawn = JSON.stringify([text, [...flashing], shows.brightness]);
    if (drawn === this.drawn) return;
    this.drawn = drawn;
    const led = text.length === 1;
    set(this.rows, {
      class: led ? "display display-led" : "display display-lcd",
      "aria-label": `${this.name} shows ${text.map((row) => row.trimEnd()).join("; ").trim() || "nothing"}`,
    });
    if (!led) {
      this.rows.replaceChildren(...text.map((row) => h("div", { class: "display-row" }, row || " ")));
      return;
    }
    const bright = typeof shows.brightness === "number" ? shows.brightness / 100 : 1;
    const cells = [...text[0]].map((letter, n) =>
      h("span", { class: `display-cell${flashing.has(n) ? ` ${FLASH}` : ""}` }, letter),
    );
    this.rows.replaceChildren(...cells);
    this.rows.style.setProperty("--bright", String(bright && 0.35 + 0.65 * bright));
  }
}

/** Thumbwheel switches: a window for each digit, with a button above and below. */
export class Thumbwheels {
  /**
   * @param {string} name
   * @param {Act} act
   */
  constructor(name, act) {
    this.name = name;
    this.act = act;
    this.value = "";
    this.asked = ""; // the requested digits, until a view shows them
    this.askedMs = 0;
    this.letter = h("b", { class: "wheels-letter" });
    this.wheels = h("div", { class: "wheels" });
    this.element = h("div", { class: "wheels-bank", role: "group", "aria-label": name }, this.letter, this.wheels);
    /** @type {HTMLElement[]} */
    this.windows = [];
  }

  /** @param {Shows} shows */
  take(shows) {
    const value = String(shows.value);
    say(this.letter, shows.letter ?? "");
    if (this.windows.length !== value.length) this.build(value.length);
    // a view may show only the effect of the first of several quick clicks: the next click counts from the requested digit
    if (value === this.asked || performance.now() - this.askedMs > TRUST_MS) this.asked = "";
    this.value = value;
    this.show();
  }

  show() {
    [...(this.asked || this.value)].forEach((digit, n) => say(this.windows[n], digit));
  }

  /** @param {number} count */
  build(count) {
    this.windows = [];
    this.wheels.replaceChildren();
    for (let n = 0; n < count; n++) {
      const place = `${this.name}, digit ${n + 1} of ${count}`;
      const digit = h("output", { class: "wheel-digit", "aria-label": place });
      this.windows.push(digit);
      const up = button("\u25b4", () => this.turn(n, 1), { class: "wheel-up", "aria-label": `${place}: up` });
      const down = button("\u25be", () => this.turn(n, -1), { class: "wheel-down", "aria-label": `${place}: down` });
      this.wheels.append(h("div", { class: "wheel" }, up, digit, down));
    }
  }

  /**
   * @param {number} n
   * @param {number} by
   */
  turn(n, by) {
    const digits = [...(this.asked || this.value)];
    digits[n] = String((Number.parseInt(digits[n], 10) + by + 10) % 10 || 0);
    this.asked = digits.join("");
    this.askedMs = performance.now();
    this.show();
    this.act("turn", Number(this.asked));
  }
}

/** A jog switch: it returns to the centre when released. */
export class JogSwitch {
  /**
   * @param {string} name
   * @param {Act} act
   */
  constructor(name, act) {
    this.act = act;
    this.ccw = h("button", { type: "button", "data-writes": true, class: "jog-side", "aria-label": `${name}: jog counter-clockwise` }, "\u21ba");
    this.cw = h("button", { type: "button", "data-writes": true, class: "jog-side", "aria-label": `${name}: jog clockwise` }, "\u21bb");
    this.lever = h("span", { class: "jog-lever", "aria-hidden": "true" });
    this.state = h("span", { class: "jog-state" }, "off");
    const gate = h("span", { class: "jog-gate" }, this.lever, this.state);
    this.element = h("div", { class: "jog", role: "group", "aria-label": name }, this.ccw, gate, this.cw);
    onHold(this.ccw, () => this.push("ccw"), () => this.push("off"));
    onHold(this.cw, () => this.push("cw"), () => this.push("off"));
  }

  /** @param {string} to */
  push(to) {
    this.show(to);
    this.act(to);
  }

  /** @param {Shows} shows */
  take(shows) {
    if (typeof shows.position === "string") this.show(shows.position);
  }

  /** @param {string} position */
  show(position) {
    set(this.element, { "data-position": position });
    set(this.ccw, { "aria-pressed": String(position === "ccw") });
    set(this.cw, { "aria-pressed": String(position === "cw") });
    say(this.state, position);
  }
}

/** A contact, open or closed. */
export class Contact {
  /** @param {string} name */
  constructor(name) {
    this.name = name;
    this.lever = svg("line", { x1: 18, y1: 20, x2: 46, y2: 8, class: "contact-lever" });
    this.picture = svg("svg", { viewBox: "0 0 64 28", class: "contact", role: "img" });
    this.picture.append(
      svg("line", { x1: 2, y1: 20, x2: 18, y2: 20 }),
      svg("line", { x1: 46, y1: 20, x2: 62, y2: 20 }),
      this.lever,
      svg("circle", { cx: 18, cy: 20, r: 3 }),
      svg("circle", { cx: 46, cy: 20, r: 3 }),
    );
    this.state_text = h("span", { class: "contact-says" });
    this.element = h("div", { class: "contact-box" }, this.picture, this.state_text);
  }

  /** @param {Shows} shows */
  take(shows) {
    const state_text = shows.closed ? "closed" : "open";
    if (this.state_text.textContent === state_text) return;
    say(this.state_text, state_text);
    set(this.lever, { y2: shows.closed ? 20 : 8 });
    set(this.element, { "data-closed": shows.closed === true });
    set(this.picture, { "aria-label": `${this.name} is ${state_text}` });
  }
}

/** Lamps, one per pin; a pin of several wires shows a number. */
export class Lamps {
  /** @param {string} name */
  constructor(name) {
    this.element = h("ul", { class: "lamps", "aria-label": `${name}: levels` });
    /** @type {Map<string, {lamp: HTMLElement, item: HTMLElement, level: any}>} */
    this.lamps = new Map();
  }

  /** @param {Record<string, any>} levels */
  take(levels) {
    for (const [pin, level] of Object.entries(levels)) {
      let one = this.lamps.get(pin);
      if (!one) {
        const lamp = h("span", { class: "lamp", "aria-hidden": "true" });
        const item = h("li", {}, lamp, h("span", {}, pin));
        one = { lamp, item, level: undefined };
        this.lamps.set(pin, one);
        this.element.append(item);
      }
      if (one.level === level) continue;
      one.level = level;
      const bit = level === 0 || level === 1 || level === null;
      const shown = level === null ? "floating" : level === 1 ? "high" : level === 0 ? "low" : String(level);
      set(one.lamp, { "data-level": bit ? (level ?? "z") : "word" });
      say(one.lamp, bit ? "" : String(level));
      set(one.item, { "aria-label": `${pin} ${shown}`, title: shown });
    }
  }
}

/** Numeric readings of a part, by name. */
export class Figures {
  constructor() {
    this.element = h("dl", { class: "figures" });
    /** @type {Map<string, HTMLElement>} */
    this.values = new Map();
  }

  /** @param {Shows} shows */
  take(shows) {
    for (const [name, value] of Object.entries(shows)) {
      let place = this.values.get(name);
      if (!place) {
        place = h("dd");
        this.values.set(name, place);
        this.element.append(h("div", {}, h("dt", {}, name.replaceAll("_", " ")), place));
      }
      say(place, plain(value));
    }
  }
}

/**
 * @param {any} value
 * @returns {string}
 */
function plain(value) {
  if (typeof value === "number") return digitsOf(value, 9);
  if (typeof value === "boolean") return value ? "yes" : "no";
  if (value === null || value === "") return "\u2013";
  if (Array.isArray(value)) return value.length ? value.slice(-8).map(plain).join(", ") : "none";
  return typeof value === "object" ? JSON.stringify(value) : String(value);
}

const COUNTED = new Map([
  ["push", "counts to push the shaft; negative: backwards"],
  ["slip", "counts to slip"],
  ["run", "counts/s"],
]);

/**
 * Create the buttons for other manual operations: one for each verb, with a number if the verb takes one.
 * @param {string} name
 * @param {string[]} verbs
 * @param {Act} act
 * @returns {HTMLElement}
 */
export function verbButtons(name, verbs, act) {
  const all = h("div", { class: "verbs", role: "group", "aria-label": `${name}: by hand` });
  const counted = verbs.filter((verb) => COUNTED.has(verb));
  for (const verb of verbs) {
    if (!COUNTED.has(verb)) all.append(button(verb, () => act(verb), { "aria-label": `${name}: ${verb}` }));
  }
  if (counted.length) {
    const label = `${name}: ${counted.map((verb) => COUNTED.get(verb)).join("; ")}`;
    const field = h("input", { type: "number", value: 10, step: 1, "aria-label": label, title: label });
    all.append(field);
    for (const verb of counted) {
      all.append(button(verb, () => act(verb, Math.round(Number(field.value) || 0)), { "aria-label": `${name}: ${verb}` }));
    }
  }
  return all;
}
