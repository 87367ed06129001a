/**
 * Ramps by hand: sliders for the parameters of a part, and the move that they give.
 *
 * Every place of the sliders is a run that was computed when the pages were built; here it is only shown.
 */

import { h, put, say } from "../../src/slewline/panel/page/dom.js";
import { control, set, svg } from "../../src/slewline/panel/page/elements.js";
import { digitsOf, ticks } from "../../src/slewline/panel/page/units.js";

/**
 * @typedef {object} Slider
 * @property {string} name
 * @property {string} says
 * @property {number[]} values
 * @property {string[]} spoken the values in steps and seconds, of a part whose numbers do not show it
 * @property {number} at its place at first
 */

/**
 * @typedef {object} Part
 * @property {string} title
 * @property {string} command with {NAME} for a value
 * @property {string[]} host what a host sends, likewise
 * @property {Slider[]} sliders
 * @property {Record<string, string[]>} output what the command prints, of every run; "": no such line
 * @property {number[][]} curves time, rate, time, rate ... of every run
 */

/** @typedef {{perSecond: number, parts: Part[]}} Data times of a curve are in units, so many of them in a second */
/** @typedef {{curve: number[], says: string}} Kept */

const HEIGHT = 300;
const LEFT = 46;
const RIGHT = 10;
const TOP = 26;
const BOTTOM = 36;
const HEADROOM = 1.05;

/** The picture of moves: velocity over time. */
class Figure {
  /** @param {number} perSecond */
  constructor(perSecond) {
    this.perSecond = perSecond;
    this.element = svg("svg", { role: "img" });
  }

  /**
   * @param {number} width
   * @param {number[]} curve
   * @param {number[][]} family what else the slider that was moved last may make of it
   * @param {number[]} [kept]
   */
  draw(width, curve, family, kept) {
    const every = [curve, ...family, ...(kept ? [kept] : [])];
    const end = Math.max(...every.map((one) => one[one.length - 2]));
    const top = Math.max(...every.flatMap((one) => one.filter((_, n) => n % 2))) * HEADROOM;
    const x = (/** @type {number} */ time) => LEFT + (time / end) * (width - LEFT - RIGHT);
    const y = (/** @type {number} */ rate) => HEIGHT - BOTTOM - (rate / top) * (HEIGHT - TOP - BOTTOM);
    const path = (/** @type {number[]} */ points) => {
      let text = `M${x(0).toFixed(1)} ${y(0)}`;
      for (let n = 0; n < points.length; n += 2) text += `L${x(points[n]).toFixed(1)} ${y(points[n + 1]).toFixed(1)}`;
      return `${text}V${y(0)}`;
    };
    set(this.element, { width, height: HEIGHT, viewBox: `0 0 ${width} ${HEIGHT}` });
    this.element.replaceChildren();
    this.#scales(width, end, top, x, y);
    for (const one of family) this.#line("beside", path(one));
    if (kept) this.#line("kept", path(kept));
    this.#line("curve", path(curve));
  }

  /**
   * @param {number} width
   * @param {number} end
   * @param {number} top
   * @param {(time: number) => number} x
   * @param {(rate: number) => number} y
   */
  #scales(width, end, top, x, y) {
    for (const rate of ticks(0, top, 6)) {
      this.element.append(svg("line", { x1: LEFT, x2: width - RIGHT, y1: y(rate), y2: y(rate) }));
      this.#text(digitsOf(rate, 5), LEFT - 6, y(rate) + 4, "end");
    }
    const [unit, name] = end < this.perSecond ? [this.perSecond / 1000, "ms"] : [this.perSecond, "s"];
    for (const time of ticks(0, end / unit, width / 60)) {
      this.element.append(svg("line", { x1: x(time * unit), x2: x(time * unit), y1: TOP, y2: y(0) + 4 }));
      this.#text(digitsOf(time, 4), x(time * unit), y(0) + 17, "middle");
    }
    this.#text("steps/s", LEFT - 6, TOP - 12, "start");
    this.#text(name, width - RIGHT, HEIGHT - 4, "end");
  }

  /**
   * @param {string} kind
   * @param {string} d
   */
  #line(kind, d) {
    this.element.append(svg("path", { class: kind, d }));
  }

  /**
   * @param {string} text
   * @param {number} x
   * @param {number} y
   * @param {string} anchor
   */
  #text(text, x, y, anchor) {
    const element = svg("text", { x, y, "text-anchor": anchor });
    say(element, text);
    this.element.append(element);
  }
}

/** What is on the page: a part, its sliders, the picture, and what the command prints. */
class Ramps {
  /** @type {Kept | undefined} */
  #kept;

  /**
   * @param {HTMLElement} place
   * @param {Data} data
   */
  constructor(place, data) {
    this.data = data;
    this.part = data.parts[0];
    /** @type {number[]} */
    this.at = [];
    this.moved = 0;
    this.figure = new Figure(data.perSecond);
    this.frame = h("div", { class: "figure-frame" });
    this.frame.append(this.figure.element);
    this.sliders = h("div", { class: "sliders" });
    this.output = h("dl", { "aria-live": "polite" });
    this.command = h("code", { class: "command" });
    this.host = h("code", { class: "host" });
    this.note = h("span", { class: "kept-note" });
    put(place, this.#chooser(), this.frame, this.sliders, this.#keeper(), this.output);
    put(place, h("p", {}, "The same in a terminal: ", this.command), h("p", {}, "A host sends: ", this.host));
    this.#choose(this.part);
    new ResizeObserver(() => this.#draw()).observe(this.frame);
  }

  /** @returns {HTMLElement} */
  #chooser() {
    const choices = this.data.parts.map((part, n) =>
      h("label", {},
        h("input", { type: "radio", name: "part", checked: n === 0, change: () => this.#choose(part) }),
        part.title,
      ));
    return h("div", { class: "parts", role: "radiogroup", "aria-label": "Part" }, ...choices);
  }

  /** @returns {HTMLElement} */
  #keeper() {
    const keep = () => {
      const values = this.part.sliders.map((slider, n) => `${slider.name} ${slider.values[this.at[n]]}`);
      const took = [...this.output.querySelectorAll("dd")].at(-1)?.textContent?.split(":")[0];
      this.#kept = { curve: this.part.curves[this.#run(this.at)], says: `${values.join(", ")}: ${took}` };
      this.#show();
    };
    return h("div", { class: "keeper" }, control("Keep this curve", keep), this.note);
  }

  /**
   * Show another part, its sliders where they stand at first.
   * @param {Part} part
   */
  #choose(part) {
    this.part = part;
    this.at = part.sliders.map((slider) => slider.at);
    this.moved = part.sliders.length - 1;
    this.#kept = undefined;
    this.sliders.replaceChildren(...part.sliders.map((slider, n) => this.#slider(slider, n)));
    this.#show();
  }

  /**
   * @param {Slider} slider
   * @param {number} n
   * @returns {HTMLElement}
   */
  #slider(slider, n) {
    const shown = h("output");
    const label = `${slider.name}: ${slider.says}`;
    const ends = { min: 0, max: slider.values.length - 1 };
    const input = h("input", { type: "range", ...ends, value: slider.at, "aria-label": label });
    const tell = () => {
      const spoken = slider.spoken[this.at[n]];
      say(shown, `${slider.values[this.at[n]]}${spoken ? ` \u2248 ${spoken}` : ""}`);
      set(input, { "aria-valuetext": `${slider.name} ${shown.textContent}` });
    };
    input.addEventListener("input", () => {
      this.at[n] = Number(input.value);
      this.moved = n;
      tell();
      this.#show();
    });
    tell();
    return h("label", {}, h("span", {}, h("b", {}, slider.name), ` ${slider.says}`), shown, input);
  }

  /**
   * Return the run of some places of the sliders.
   * @param {number[]} at
   * @returns {number}
   */
  #run(at) {
    return this.part.sliders.reduce((run, slider, n) => run * slider.values.length + at[n], 0);
  }

  /**
   * Return a text with values in the place of their names.
   * @param {string} text
   * @returns {string}
   */
  #filled(text) {
    return this.part.sliders.reduce(
      (filled, slider, n) => filled.replace(`{${slider.name}}`, String(slider.values[this.at[n]])), text);
  }

  #show() {
    const run = this.#run(this.at);
    const rows = Object.entries(this.part.output).filter(([, lines]) => lines[run]);
    this.output.replaceChildren(...rows.flatMap(([label, lines]) => [h("dt", {}, label), h("dd", {}, lines[run])]));
    say(this.command, this.#filled(this.part.command));
    say(this.host, this.part.host.map((line) => this.#filled(line)).join("; "));
    say(this.note, this.#kept?.says ?? "");
    set(this.figure.element, { "aria-label": `Velocity over time: ${rows.map(([, lines]) => lines[run]).join("; ")}` });
    this.#draw();
  }

  #draw() {
    const { curves, sliders } = this.part;
    const family = sliders[this.moved].values.map((_, n) => curves[this.#run(this.at.with(this.moved, n))]);
    const width = this.frame.clientWidth;
    if (width) this.figure.draw(width, curves[this.#run(this.at)], family, this.#kept?.curve);
  }
}

/**
 * Put the sliders in place of the picture that stands for them without a script.
 * @param {string} packed the data: JSON, deflated, in base64
 */
export async function begin(packed) {
  const place = document.querySelector(".by-hand");
  if (!(place instanceof HTMLElement)) return;
  const bytes = Uint8Array.from(atob(packed), (one) => one.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  const data = await new Response(stream).json();
  place.replaceChildren();
  place.classList.add("moves"); // before the curve is drawn: it sets the width of the figure
  new Ramps(place, data);
  performance.mark("by-hand");
}
