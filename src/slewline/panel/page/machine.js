/**
 * The machine: every part on the bench, with its state and buttons for its verbs, and a shaft for each axis.
 */

import { h, say } from "./dom.js";
import { Contact, Display, Figures, JogSwitch, Lamps, Thumbwheels, verbButtons } from "./front_panel.js";
import { Rail } from "./rail.js";
import { ShaftDial } from "./shaft.js";
import { Strips } from "./strips.js";
import { drawDue } from "./surface.js";
import { digitsOf } from "./units.js";

/** @typedef {import("./link.js").Link} Link */
/** @typedef {Record<string, any>} Data */
/** @typedef {{jumped: boolean, legible: boolean, nowPs: number, rate: number, view: Data, hasLever: boolean}} Moment */
/** @typedef {{element: HTMLElement, take: (moment: Moment) => void, close: () => void}} Card */

const AXIS_TURN = 200; // steps per revolution of the motor drawn for an axis of a chip
const LAMP_ROLES = /^(output\d|ready|running|slewing|moving|motion_complete|ramping|program_entry|interrupt)$/;
const JOG = ["cw", "ccw", "off"];
const SHAFT_KEYS = ["angle", "per_turn", "position", "place", "low", "high", "unit", "spots", "lit", "on"];

/**
 * Draw the machine.
 * @param {Link} link
 * @param {HTMLElement} root
 * @returns {{update: (view: any, timePs: number, legible: boolean) => void, close: () => void, moves: boolean}}
 */
export function machine(link, root) {
  return new Machine(link, root);
}

class Machine {
  /**
   * @param {Link} link
   * @param {HTMLElement} root
   */
  constructor(link, root) {
    this.link = link;
    this.grid = h("div", { class: "machine" });
    this.problem = h("p", { class: "draw-problem", role: "alert", hidden: true });
    root.replaceChildren(this.problem, this.grid);
    /** @type {Map<string, Card>} */
    this.cards = new Map();
    /** Parts from the reply to `parts`, or null before it arrives. @type {Data | null} */
    this.parts = null;
    this.asked = false;
    this.lastPs = 0;
    this.jump = true;
    this.moves = true;
    this.ends = [
      link.on("branch", () => {
        this.jump = true;
      }),
    ];
    this.update();
  }

  close() {
    for (const end of this.ends) end();
    this.clear();
  }

  clear() {
    for (const card of this.cards.values()) card.close();
    this.cards.clear();
    this.grid.replaceChildren();
    this.parts = null;
  }

  async learn() {
    this.asked = true;
    try {
      this.parts = (await this.link.request({ do: "parts" })).parts;
      this.update();
    } catch (error) {
      this.tell(error);
    }
  }

  /** @param {unknown} error */
  tell(error) {
    say(this.problem, error instanceof Error ? error.message : String(error));
    this.problem.hidden = false;
  }

  /**
   * Draw changes; called for every frame in which something may have changed.
   * @param {any} [view]
   * @param {number} [timePs]
   * @param {boolean} [legible] whether to update text as well
   */
  update(view = this.link.view, timePs = this.link.timePs, legible = true) {
    const jumped = this.jump || timePs < this.lastPs;
    this.jump = false;
    this.lastPs = timePs;
    const rate = view.pace?.lockstep ? 1 : (view.pace?.rate ?? 1);
    const hasLever = Object.values(this.parts ?? {}).some((info) => JOG.every((verb) => info.verbs?.includes(verb)));
    const moment = { jumped, legible: legible || jumped, nowPs: timePs, rate, view, hasLever };
    for (const [name, chip] of Object.entries(view.chips ?? {})) {
      chip.axes?.forEach((/** @type {Data} */ _, /** @type {number} */ n) => {
        const key = `axis ${name} ${n}`;
        if (!this.cards.has(key)) this.add(key, new AxisCard(this.link, name, n, chip.axes.length > 1));
      });
    }
    let unknown = false;
    for (const name of Object.keys(view.parts ?? {})) {
      const info = this.parts?.[name];
      if (info && !this.cards.has(name) && seen(info, view.parts[name])) this.add(name, new PartCard(name, info, view.parts[name], this.actor(name)));
      else if (!info) unknown = true;
    }
    if (unknown && !this.asked) this.learn();
    for (const card of this.cards.values()) card.take(moment);
    drawDue();
  }

  /**
   * @param {string} key
   * @param {Card} card
   */
  add(key, card) {
    this.cards.set(key, card);
    this.grid.classList.toggle("many", [...this.cards.values()].filter(isAxis).length > 1);
    this.grid.append(card.element);
  }

  /**
   * Return the function that operates a part.
   * @param {string} part
   * @returns {import("./front_panel.js").Act}
   */
  actor(part) {
    return (verb, ...args) => {
      this.problem.hidden = true;
      this.link.request({ do: "act", part, verb, args }).catch((error) => this.tell(error));
    };
  }
}

/**
 * Return whether a card belongs to an axis.
 * @param {Card} card
 * @returns {boolean}
 */
function isAxis(card) {
  return card instanceof AxisCard;
}

/**
 * Return whether a part has anything to show or operate; a host, for example, has not.
 * @param {Data} info
 * @param {Data} part
 * @returns {boolean}
 */
function seen(info, part) {
  return [info.verbs, Object.keys(part?.shows ?? {}), Object.keys(part?.levels ?? {})].some((all) => all?.length > 0);
}

/**
 * Create a frame with a heading.
 * @param {string} name
 * @param {string} kind
 * @param {string} look
 * @returns {HTMLElement}
 */
function frame(name, kind, look) {
  const heading = h("h3", { class: "bench-title" }, name, h("small", {}, kind));
  return h("section", { class: `bench-card ${look}`, "aria-label": `${name}, ${kind}` }, heading);
}

/** A figure with its name and unit. */
class Reading {
  /**
   * @param {string} name
   * @param {string} unit
   */
  constructor(name, unit) {
    this.value = h("span", { class: "bench-value" }, "0");
    const label = h("span", { class: "bench-name" }, name);
    this.element = h("div", { class: "bench-reading" }, label, this.value, h("span", { class: "bench-unit" }, unit));
  }

  /** @param {number} value */
  show(value) {
    say(this.value, digitsOf(value, 7));
  }
}

/** An axis of a chip: the shaft that its steps would turn and its strips; the first axis also has the lamps of the chip. */
class AxisCard {
  /**
   * @param {Link} link
   * @param {string} chip
   * @param {number} axis counted from 0
   * @param {boolean} several
   */
  constructor(link, chip, axis, several) {
    this.chip = chip;
    this.axis = axis;
    const name = several ? `${chip} axis ${axis + 1}` : chip;
    this.dial = new ShaftDial(`shaft of ${name}`);
    this.strips = new Strips(name);
    this.position = new Reading("position", "steps");
    this.velocity = new Reading("velocity", "steps/s");
    this.lamps = new Lamps(name);
    /** @type {string[]} */
    this.lit = [];
    this.state = h("span", { class: "axis-state" });
    /** @type {HTMLElement | undefined} */
    this.jog = undefined;
    const readings = h("div", { class: "bench-readings" }, this.position.element, this.velocity.element, this.state);
    this.element = frame(name, "axis", "bench-axis");
    const left = h("div", { class: "axis-shaft" }, this.dial.element, readings);
    this.element.append(h("div", { class: "axis-row" }, left, this.strips.canvas), this.lamps.element);
    link.request({ do: "describe", chip }).then(
      ({ sheet }) => {
        const jog = sheet.pins.find((/** @type {Data} */ pin) => pin.role === "jog");
        if (jog && axis === 0) this.addJog(link, chip, jog.name);
        this.lit = sheet.pins
          .filter((/** @type {Data} */ pin) => LAMP_ROLES.test(pin.role ?? "") && pin.way !== "in")
          .filter((/** @type {Data} */ pin) => (several ? (pin.axis ?? 1) === axis + 1 : true))
          .map((/** @type {Data} */ pin) => pin.name);
      },
      () => {}, // no lamps then; the package shows the error
    );
  }

  /**
   * Put jog buttons below the shaft of a chip that has a pin for them: low steps clockwise, high counter-clockwise.
   * @param {Link} link
   * @param {string} chip
   * @param {string} pin
   */
  addJog(link, chip, pin) {
    const full = `${chip}.${pin}`;
    const jog = new JogSwitch(`jog of ${chip}`, (to) => {
      const request = to === "off" ? { do: "release", pin: full } : { do: "drive", pin: full, level: to === "cw" ? 0 : 1 };
      link.request(request).catch(() => jog.show("off"));
    });
    this.jog = jog.element;
    this.element.append(jog.element);
  }

  close() {
    this.dial.close();
    this.strips.close();
    this.element.remove();
  }

  /** @param {Moment} moment */
  take({ view, jumped, legible, nowPs, rate, hasLever }) {
    const chip = view.chips?.[this.chip];
    const axis = chip?.axes?.[this.axis];
    if (!axis) return;
    this.dial.take(axis.position, AXIS_TURN, jumped);
    this.strips.take(nowPs, axis.position, axis.velocity ?? 0, rate);
    if (!legible) return;
    this.position.show(axis.position);
    this.velocity.show(axis.velocity ?? 0);
    if (this.jog) this.jog.hidden = hasLever; // the machine has its own jog switch
    say(this.state, axis.moving ? "moving" : "at rest");
    if (this.lit.length) this.lamps.take(Object.fromEntries(this.lit.map((pin) => [pin, chip.levels?.[pin] ?? null])));
  }
}

/** A part of the bench. */
class PartCard {
  /**
   * @param {string} name
   * @param {Data} info
   * @param {Data} part
   * @param {import("./front_panel.js").Act} act
   */
  constructor(name, info, part, act) {
    this.name = name;
    this.kind = words(String(info.kind ?? ""));
    /** @type {string[]} */
    const verbs = info.verbs ?? [];
    /** @type {((moment: Moment, shows: Data) => void)[]} */
    this.takers = [];
    /** Updates of text. @type {((moment: Moment, shows: Data) => void)[]} */
    this.legible = [];
    /** @type {(() => void)[]} */
    this.closers = [];
    this.element = frame(name, this.kind, "bench-part");
    const shows = part?.shows ?? {};
    const keys = new Set(Object.keys(shows));
    const rest = new Set(verbs);
    this.shaft(shows, keys);
    if ("text" in shows) this.simple(new Display(name), keys, ["text", "rows", "brightness", "flashing"]);
    if ("value" in shows && rest.delete("turn")) this.simple(new Thumbwheels(name, act), keys, ["value", "letter"]);
    if (JOG.every((verb) => rest.has(verb))) {
      this.simple(new JogSwitch(name, act), keys, ["position"]);
      for (const verb of JOG) rest.delete(verb);
    }
    if ("closed" in shows) this.simple(new Contact(name), keys, ["closed", "low", "high", "on"]);
    if (keys.size) {
      const figures = new Figures();
      this.element.append(figures.element);
      const left = [...keys];
      this.legible.push((_, now) => figures.take(Object.fromEntries(left.map((key) => [key, now[key]]))));
    }
    if (rest.size) this.element.append(verbButtons(name, [...rest], act));
    const lamps = new Lamps(name);
    this.legible.push(({ view }) => lamps.take(view.parts?.[name]?.levels ?? {}));
    this.element.append(lamps.element);
  }

  close() {
    for (const end of this.closers) end();
    this.element.remove();
  }

  /**
   * Draw a part from its state alone.
   * @param {{element: HTMLElement, take: (shows: Data) => void}} one
   * @param {Set<string>} keys not drawn yet
   * @param {string[]} own
   */
  simple(one, keys, own) {
    this.element.append(one.element);
    this.legible.push((_, shows) => one.take(shows));
    for (const key of own) keys.delete(key);
  }

  /**
   * Draw a part that turns as a shaft, and a part with a linear position as a carriage.
   * @param {Data} shows
   * @param {Set<string>} keys
   */
  shaft(shows, keys) {
    const turns = typeof shows.angle === "number" || (typeof shows.position === "number" && "per_turn" in shows);
    const moves = typeof shows.place === "number" || (typeof shows.position === "number" && !turns);
    if (!turns && !moves) return;
    for (const key of SHAFT_KEYS) keys.delete(key);
    const key = ["angle", "place", "position"].find((one) => typeof shows[one] === "number") ?? "position";
    const reading = new Reading(key, shows.unit ?? "steps");
    if (turns) {
      const dial = new ShaftDial(`shaft of ${this.name}`);
      this.closers.push(() => dial.close());
      this.element.append(h("div", { class: "part-shaft" }, dial.element, reading.element));
      this.takers.push(({ jumped }, now) => {
        dial.take(now.angle ?? now.position, now.per_turn ?? AXIS_TURN, jumped);
      });
      this.legible.push((_, now) => reading.show(now[key]));
      return;
    }
    const rail = new Rail(`carriage ${this.name}`);
    this.closers.push(() => rail.close());
    this.element.classList.add("bench-wide");
    this.element.append(rail.element, reading.element);
    this.takers.push(({ jumped, view }, now) => {
      const { low, high, unit, lit, spots } = now;
      const marks = Array.isArray(spots) ? spots.map((one) => (typeof one === "number" ? one : one.position)) : [];
      rail.take(now[key], jumped, { low, high, unit, lit: Boolean(lit), marks, zones: zones(view, this.name) });
    });
    this.legible.push((_, now) => reading.show(now[key]));
  }

  /** @param {Moment} moment */
  take(moment) {
    const shows = moment.view.parts?.[this.name]?.shows ?? {};
    for (const take of this.takers) take(moment, shows);
    if (moment.legible) for (const take of this.legible) take(moment, shows);
  }
}

/**
 * Return the name of a kind of part in words: HpDisplay, hp_display.
 * @param {string} kind
 * @returns {string}
 */
function words(kind) {
  return kind.replace(/(?<=[a-z0-9])(?=[A-Z])/g, " ").replaceAll("_", " ").toLowerCase();
}

/**
 * Return the switches that sit on a part.
 * @param {Data} view
 * @param {string} part
 * @returns {import("./rail.js").Zone[]}
 */
function zones(view, part) {
  return Object.entries(view.parts ?? {})
    .filter(([, { shows }]) => shows?.on === part && "closed" in shows && (shows.low ?? shows.high ?? null) !== null)
    .map(([name, { shows }]) => ({ name, low: shows.low ?? null, high: shows.high ?? null, closed: shows.closed === true }));
}

