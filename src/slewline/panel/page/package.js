/**
 * The package of a chip with its pins: present levels, and inputs to press, hold and release.
 *
 * A short press holds an input, the next one releases it; a long press drives it only while it lasts.  The keyboard does
 * the same: arrows move between pins, space or Enter presses, 0 and 1 hold a level, Escape releases it.
 */

import { h, say } from "./dom.js";
import { control, set } from "./elements.js";
import { onHold } from "./hold.js";
import { hasSignal, levelText, packages, pressedLevel, twoRows, inOutText } from "./package_layout.js";

/** @typedef {import("./package_layout.js").Pin} Pin */
/** @typedef {import("./package_layout.js").Package} Package */
/** @typedef {import("./link.js").Link} Link */

/** Names are shown in full; the body takes the remaining width. */
const ROWS_OF_TWO = "minmax(max-content, 1fr) minmax(1.5rem, min(18cqw, 7rem)) minmax(max-content, 1fr)";
const SHORT_MS = 350; // a press up to here holds the pin
const NARROW_PX = 640; // below, a square package is drawn in two rows
const MARKS = new Map([
  [1, "1"],
  [0, "0"],
]);
const OPEN = "z"; // not driven

/**
 * Return two rows of equal length of the pins that carry a signal, in their order round the package.
 * @param {(Pin | number)[][]} rows
 * @returns {Pin[][]}
 */
function halves([left, right]) {
  /** @type {Pin[]} */
  const found = [];
  for (const pin of [...left, ...[...right].reverse()]) if (typeof pin !== "number" && hasSignal(pin)) found.push(pin);
  const half = Math.ceil(found.length / 2);
  return [found.slice(0, half), found.slice(half).reverse()];
}

/**
 * Draw the package of a chip.
 * @param {Link} link
 * @param {string} chipName
 * @param {HTMLElement} root
 * @returns {{update: () => void, close: () => void}}
 */
export function packageView(link, chipName, root) {
  return new PackageView(link, chipName, root);
}

class PackageView {
  /**
   * @param {Link} link
   * @param {string} chip
   * @param {HTMLElement} root
   */
  constructor(link, chip, root) {
    this.link = link;
    this.chip = chip;
    this.root = root;
    /** @type {Map<string, {pin: Pin, element: HTMLElement, mark: HTMLElement, shown: string}>} */
    this.pins = new Map();
    /** Levels that this page holds and that no view shows yet. @type {Map<string, 0 | 1>} */
    this.held = new Map();
    /** @type {Package[]} */
    this.packages = [];
    this.sheet = { part: "", title: "" };
    this.narrow = false;
    this.whole = false; // in a narrow layout: also show pins without a signal
    this.current = "";
    this.closed = false;
    this.body = h("div", { class: "packages" });
    this.says = h("p", { class: "pin-says" });
    this.problem = h("p", { class: "draw-problem", role: "alert", hidden: true });
    root.replaceChildren(this.body, this.says, this.problem);
    this.sizes = new ResizeObserver(() => this.resized());
    this.end = link.on("branch", () => this.held.clear()); // inputs return to their levels at that time
    this.load();
  }

  close() {
    this.closed = true;
    this.sizes.disconnect();
    this.end();
    this.root.replaceChildren();
  }

  async load() {
    try {
      const { sheet } = await this.link.request({ do: "describe", chip: this.chip });
      if (this.closed) return;
      this.sheet = sheet;
      this.packages = packages(sheet);
      this.narrow = this.root.clientWidth < NARROW_PX;
      this.build();
      this.sizes.observe(this.root);
    } catch (error) {
      this.tell(error);
    }
  }

  /** @param {unknown} error */
  tell(error) {
    say(this.problem, error instanceof Error ? error.message : String(error));
    this.problem.hidden = false;
  }

  resized() {
    const narrow = this.root.clientWidth < NARROW_PX;
    if (narrow === this.narrow) return;
    this.narrow = narrow;
    if (this.packages.some((one) => one.square)) this.build();
  }

  // ------------------------------------------------------------------------------------------------------- elements
  build() {
    this.pins.clear();
    this.body.replaceChildren(...this.packages.map((one) => this.onePackage(one)));
    this.current = this.pins.keys().next().value ?? "";
    this.pins.get(this.current)?.element.setAttribute("tabindex", "0");
    this.update();
    this.explain(null);
  }

  /**
   * @param {Package} one
   * @returns {HTMLElement}
   */
  onePackage(one) {
    const square = one.square && !this.narrow;
    const folded = one.square && !square;
    const brief = folded && !this.whole;
    const sides = square ? one.sides : brief ? halves(twoRows(one)) : twoRows(one);
    const part = this.sheet.part.toUpperCase();
    const name = `${this.chip}: ${part}${one.name ? `, ${one.name}` : ""}`;
    const printed = h("span", { class: "package-print", "aria-hidden": "true" }, h("b", {}, part), one.name);
    const grid = h("div", { class: square ? "package square" : "package dual", role: "group", "aria-label": name });
    const count = Math.max(...sides.map((side) => side.length));
    // the grid has as many rows as a side has pins, for any part
    const tracks = `repeat(${count}, var(--pin-pitch))`;
    grid.style.gridTemplateRows = square ? `auto ${tracks} auto` : tracks;
    grid.style.gridTemplateColumns = square ? `auto ${tracks} auto` : ROWS_OF_TWO;
    const body = h("div", { class: "package-body" }, printed);
    if (one.numbered) body.append(h("span", { class: "package-notch", "aria-hidden": "true" }));
    body.style.gridArea = square ? `2 / 2 / ${count + 2} / ${count + 2}` : `1 / 2 / ${count + 1} / 3`;
    grid.append(body);
    const names = square ? ["left", "bottom", "right", "top"] : ["left", "right"];
    sides.forEach((side, which) => {
      side.forEach((pin, at) => grid.append(this.onePin(pin, names[which], at, count, square)));
    });
    const figure = h("figure", { class: "package-figure" }, grid);
    if (folded) {
      const says = brief ? "All pins" : "Only pins with a signal";
      const change = () => {
        this.whole = !this.whole;
        this.build();
      };
      figure.append(control(says, change, { class: "package-all", "aria-label": `${name}: ${says.toLowerCase()}` }));
    }
    if (one.loose.length) {
      const loose = h("div", { class: "package-loose" }, "number not known: ");
      for (const pin of one.loose) loose.append(this.onePin(pin, "loose", 0, 0, false));
      figure.append(loose);
    }
    if (!one.numbered) {
      figure.append(h("figcaption", {}, "The numbers of its pins are not known; they are in the order of the manual."));
    }
    return figure;
  }

  /**
   * @param {Pin | number} pin
   * @param {string} side
   * @param {number} at
   * @param {number} count
   * @param {boolean} square
   * @returns {HTMLElement}
   */
  onePin(pin, side, at, count, square) {
    const shift = square ? 2 : 1;
    const missing = typeof pin === "number";
    const name = h("span", { class: "pin-name" }, missing ? "" : pin.name);
    const number = h("span", { class: "pin-number" }, String(missing ? pin : pin.number || ""));
    const mark = h("span", { class: "pin-mark", "aria-hidden": "true" });
    const works = !missing && (pin.way === "in" || pin.way === "both");
    const element = h(works ? "button" : "span", { class: `pin pin-${side}`, type: works ? "button" : null });
    element.append(name, mark, number);
    if (side === "left" || side === "right") {
      element.style.gridRow = String(at + shift);
      element.style.gridColumn = side === "left" ? "1" : "3";
      if (square) element.style.gridColumn = side === "left" ? "1" : String(count + 2);
    } else if (square) {
      element.style.gridColumn = String(at + shift);
      element.style.gridRow = side === "top" ? "1" : String(count + 2);
    }
    if (missing) {
      mark.remove();
      set(element, { class: `pin pin-${side} pin-missing`, "aria-hidden": "true" });
      return element;
    }
    set(element, { "data-way": pin.way, "data-low": pin.active === 0, tabindex: "-1" });
    if (!works) element.setAttribute("role", "img");
    if (works) this.workable(pin, element);
    if (!hasSignal(pin)) mark.remove();
    element.addEventListener("pointerenter", () => this.explain(pin));
    element.addEventListener("focus", () => this.entered(pin));
    element.addEventListener("keydown", (event) => this.key(/** @type {KeyboardEvent} */ (event), pin));
    this.pins.set(pin.name, { pin, element, mark, shown: "" });
    return element;
  }

  /**
   * @param {Pin} pin
   * @param {HTMLElement} element
   */
  workable(pin, element) {
    let wasHeld = false;
    onHold(
      element,
      () => {
        wasHeld = this.isHeld(pin);
        if (!wasHeld && this.link.writes) this.drive(pin, pressedLevel(pin, this.level(pin)));
      },
      (heldMs) => {
        if (wasHeld || heldMs > SHORT_MS) this.release(pin);
      },
    );
  }

  // ------------------------------------------------------------------------------------------------------ what is done
  /**
   * @param {Pin} pin
   * @returns {number | null | undefined}
   */
  level(pin) {
    return this.link.view.chips?.[this.chip]?.levels?.[pin.name];
  }

  /**
   * Return whether a level is held from outside: by this page, by another page, or by a program.
   * @param {Pin} pin
   * @returns {boolean}
   */
  isHeld(pin) {
    return this.held.has(pin.name) || typeof this.link.view.chips?.[this.chip]?.held?.[pin.name] === "number";
  }

  /**
   * @param {Pin} pin
   * @param {0 | 1} level
   */
  drive(pin, level) {
    this.held.set(pin.name, level);
    this.ask({ do: "drive", pin: `${this.chip}.${pin.name}`, level });
  }

  /** @param {Pin} pin */
  release(pin) {
    const held = this.isHeld(pin);
    this.held.delete(pin.name);
    if (held) this.ask({ do: "release", pin: `${this.chip}.${pin.name}` });
  }

  /** @param {Record<string, any>} request */
  ask(request) {
    this.problem.hidden = true;
    this.update();
    this.link.request(request).catch((error) => {
      if (request.do === "drive") this.held.delete(request.pin.slice(this.chip.length + 1));
      this.update();
      this.tell(error);
    });
  }

  /**
   * @param {KeyboardEvent} event
   * @param {Pin} pin
   */
  key(event, pin) {
    const works = this.link.writes && (pin.way === "in" || pin.way === "both");
    if (works && (event.key === "0" || event.key === "1")) this.drive(pin, event.key === "1" ? 1 : 0);
    else if (works && event.key === "Escape") this.release(pin);
    else if (!this.go(event.key, pin)) return;
    event.preventDefault();
  }

  /**
   * Move to the next pin in the direction of an arrow: the nearest one in the drawing.
   * @param {string} key
   * @param {Pin} from
   * @returns {boolean} whether the key is an arrow
   */
  go(key, from) {
    const steps = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
    const all = [...this.pins.values()];
    if (key === "Home" || key === "End") all.at(key === "Home" ? 0 : -1)?.element.focus();
    const step = steps[/** @type {keyof typeof steps} */ (key)];
    if (!step) return key === "Home" || key === "End";
    const middle = (/** @type {HTMLElement} */ element) => {
      const box = element.getBoundingClientRect();
      return [box.x + box.width / 2, box.y + box.height / 2];
    };
    const here = middle(/** @type {HTMLElement} */ (this.pins.get(from.name)?.element));
    let best = Infinity;
    /** @type {HTMLElement | null} */
    let target = null;
    for (const { element } of all) {
      const there = middle(element);
      const ahead = (there[0] - here[0]) * step[0] + (there[1] - here[1]) * step[1];
      const aside = Math.abs((there[0] - here[0]) * step[1]) + Math.abs((there[1] - here[1]) * step[0]);
      if (ahead > 2 && ahead + 3 * aside < best) {
        best = ahead + 3 * aside;
        target = element;
      }
    }
    target?.focus();
    return true;
  }

  /** @param {Pin} pin */
  entered(pin) {
    this.pins.get(this.current)?.element.setAttribute("tabindex", "-1");
    this.current = pin.name;
    this.pins.get(pin.name)?.element.setAttribute("tabindex", "0");
    this.explain(pin);
  }

  // ----------------------------------------------------------------------------------------------------- what is shown
  /**
   * Describe a pin in one line.
   * @param {Pin | null} pin
   */
  explain(pin) {
    if (!pin) {
      say(this.says, "A short press holds an input, and the next one releases it; a long press drives it only while pressed.");
      return;
    }
    const active = pin.active === 0 ? ", active low" : pin.active === 1 ? ", active high" : "";
    const number = pin.number ? `${pin.number} ` : "";
    this.says.replaceChildren(h("b", {}, number + pin.name), ` ${inOutText(pin)}${active}: ${pin.says}`);
  }

  /** Draw changes; called for every frame in which something may have changed. */
  update() {
    const owner = Object.keys(this.link.view.chips ?? {}).length > 1 ? `${this.chip}: ` : ""; // of several with this pin
    for (const one of this.pins.values()) {
      const { pin, element, mark } = one;
      const level = this.level(pin);
      const held = this.isHeld(pin);
      const shown = `${level} ${held} ${this.link.writes}`;
      if (shown === one.shown) continue;
      one.shown = shown;
      const signal = hasSignal(pin);
      const number = pin.number ? `pin ${pin.number} ` : "pin ";
      const state = signal ? `, ${levelText(level)}${held ? ", held" : ""}` : "";
      set(element, {
        "aria-label": `${owner}${number}${pin.name}, ${inOutText(pin)}${state}`,
        "aria-pressed": element.localName === "button" ? String(held) : null,
        "aria-disabled": element.localName === "button" && !this.link.writes ? "true" : null,
        "data-level": signal ? (level === 1 ? "1" : level === 0 ? "0" : "z") : null,
        "data-active": pin.active !== null && level === pin.active,
        "data-held": held,
        title: pin.says,
      });
      say(mark, MARKS.get(/** @type {number} */ (level)) ?? OPEN);
    }
  }
}
