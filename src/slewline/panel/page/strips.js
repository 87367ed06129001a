/**
 * Strips of velocity and position of an axis, of the last seconds.
 */

import { h } from "./dom.js";
import { Ring } from "./motion.js";
import { Surface } from "./surface.js";
import { SECOND, digitsOf, roundRange, timeText } from "./units.js";

/** @typedef {import("./surface.js").Colours} Colours */

const KEPT = 640; // values of each: ten seconds of views, twice over
const SPAN_S = 10; // on the clock of the wall
const PICTURE_MS = 100;
const LEFT = 6;

export class Strips {
  /** @param {string} name for those who do not see them */
  constructor(name) {
    this.velocity = new Ring(KEPT);
    this.position = new Ring(KEPT);
    this.nowPs = 0;
    this.spanPs = SPAN_S * SECOND;
    this.canvas = h("canvas", { class: "strips", role: "img", "aria-label": `${name}: velocity and position over time` });
    this.surface = new Surface(this.canvas, (...all) => this.draw(...all), PICTURE_MS);
  }

  close() {
    this.surface.close();
  }

  /**
   * Take what a view says.
   * @param {number} ps
   * @param {number} position
   * @param {number} velocity
   * @param {number} rate virtual seconds in a second
   */
  take(ps, position, velocity, rate) {
    const spanPs = SPAN_S * rate * SECOND;
    if (ps === this.nowPs && this.velocity.count && spanPs === this.spanPs) return;
    this.spanPs = spanPs;
    this.nowPs = ps;
    this.velocity.add(ps, velocity);
    this.position.add(ps, position);
    this.surface.changed();
  }

  /**
   * @param {CanvasRenderingContext2D} context
   * @param {number} width
   * @param {number} height
   * @param {Colours} colours
   * @param {number} _nowMs
   */
  draw(context, width, height, colours, _nowMs) {
    const half = Math.floor((height - 16) / 2);
    context.font = `11px ${colours.font}`;
    const from = this.nowPs - this.spanPs;
    const x = (/** @type {number} */ ps) => LEFT + ((ps - from) / this.spanPs) * (width - 2 * LEFT);
    grid(context, width, height - 15, colours);
    strip(context, this.velocity, x, from, 0, half - 4, true, ["velocity", "steps/s"], colours.velocity, colours, width);
    strip(context, this.position, x, from, half + 4, half - 4, false, ["position", "steps"], colours.position, colours, width);
    context.fillStyle = colours.muted;
    context.textBaseline = "bottom";
    context.textAlign = "left";
    context.fillText(`${timeText(-this.spanPs, 3)}`, LEFT, height);
    context.textAlign = "right";
    context.fillText("now", width - LEFT, height);
  }
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {number} width
 * @param {number} height
 * @param {Colours} colours
 */
function grid(context, width, height, colours) {
  context.beginPath();
  for (let n = 0; n <= SPAN_S; n++) {
    const x = Math.round(LEFT + (n / SPAN_S) * (width - 2 * LEFT)) + 0.5;
    context.moveTo(x, 0);
    context.lineTo(x, height);
  }
  context.strokeStyle = colours.faint;
  context.stroke();
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {Ring} ring
 * @param {(ps: number) => number} x
 * @param {number} from
 * @param {number} top
 * @param {number} height
 * @param {boolean} zero its range has 0 in it
 * @param {string[]} words
 * @param {string} colour
 * @param {Colours} colours
 * @param {number} width
 */
function strip(context, ring, x, from, top, height, zero, words, colour, colours, width) {
  const first = ring.count ? ring.before(from) : 0;
  let [low, high] = zero ? [0, 0] : [Infinity, -Infinity];
  for (let n = first; n < ring.count; n++) {
    low = Math.min(low, ring.value(n));
    high = Math.max(high, ring.value(n));
  }
  if (low > high) [low, high] = [0, 0];
  [low, high] = low === high ? [low - (zero ? 0 : 1), high + 1] : roundRange(low, high);
  const inside = height - 15;
  const y = (/** @type {number} */ value) => top + 14 + inside - ((value - low) / (high - low)) * inside;
  context.strokeStyle = colours.line;
  context.beginPath();
  const base = Math.round(y(zero ? 0 : low)) + 0.5;
  context.moveTo(LEFT, base);
  context.lineTo(width - LEFT, base);
  context.stroke();
  context.save();
  context.beginPath();
  context.rect(LEFT, top, width - 2 * LEFT, height + 2);
  context.clip();
  context.beginPath();
  for (let n = first; n < ring.count; n++) context.lineTo(x(ring.time(n)), y(ring.value(n)));
  context.strokeStyle = colour;
  context.lineWidth = 1.5;
  context.lineJoin = "round";
  context.stroke();
  context.restore();
  context.lineWidth = 1;
  context.textBaseline = "top";
  context.textAlign = "left";
  context.fillStyle = colour;
  context.fillText(words[0], LEFT + 2, top);
  context.textAlign = "right";
  context.fillStyle = colours.muted;
  context.fillText(`${digitsOf(low, 6)} \u2026 ${digitsOf(high, 6)} ${words[1]}`, width - LEFT - 2, top);
}
