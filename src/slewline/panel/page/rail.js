/**
 * A carriage on its rail: scale, hard stops, its switches, and the marks that it has made.
 */

import { h } from "./dom.js";
import { set } from "./elements.js";
import { Follower } from "./motion.js";
import { Moving, Surface, calm } from "./surface.js";
import { digitsOf, niceStep, roundRange, ticks } from "./units.js";

/** @typedef {import("./surface.js").Colours} Colours */
/** @typedef {{name: string, low: number | null, high: number | null, closed: boolean}} Zone */

const MARGIN = 26;
const CARRIAGE = 26;
const LEAST_SPAN = 20;
const MOST_MARKS = 500;

export class Rail {
  /** @param {string} name accessible name */
  constructor(name) {
    this.follower = new Follower();
    /** @type {number | null} */
    this.low = null;
    /** @type {number | null} */
    this.high = null;
    this.least = 0;
    this.most = 0;
    this.unit = "";
    this.lit = false;
    /** @type {number[]} */
    this.marks = [];
    /** @type {Zone[]} */
    this.zones = [];
    this.drawn = "";
    this.canvas = h("canvas", { class: "rail-scale" });
    this.carriage = h("div", { class: "carriage" });
    this.name = name;
    this.element = h("div", { class: "rail", role: "img", "aria-label": name }, this.canvas, this.carriage);
    this.surface = new Surface(this.canvas, (...all) => this.draw(all[0], all[1], all[2], all[3]));
    this.moving = new Moving(this.element, (nowMs) => this.move(nowMs));
  }

  close() {
    this.surface.close();
    this.moving.close();
  }

  /**
   * @param {number} nowMs
   * @returns {boolean}
   */
  move(nowMs) {
    const [low, high] = this.range();
    const inside = this.moving.width - 2 * MARGIN;
    const x = MARGIN + ((this.follower.at(nowMs) - low) / (high - low || 1)) * inside - CARRIAGE / 2;
    this.carriage.style.transform = `translateX(${x.toFixed(1)}px)`;
    return this.follower.moves && !calm();
  }

  /**
   * Take the state from a view.
   * @param {number} place
   * @param {boolean} jump
   * @param {{low?: number | null, high?: number | null, unit?: string, lit?: boolean, marks?: number[], zones?: Zone[]}} more
   */
  take(place, jump, more) {
    const nowMs = performance.now();
    const before = this.follower.value;
    if (Number.isNaN(before)) this.least = this.most = place;
    this.least = Math.min(this.least, place);
    this.most = Math.max(this.most, place);
    this.low = more.low ?? null;
    this.high = more.high ?? null;
    this.unit = more.unit ?? "";
    this.lit = more.lit ?? false;
    this.marks = (more.marks ?? []).slice(-MOST_MARKS);
    this.zones = more.zones ?? [];
    if (jump || calm()) this.follower.jump(place, nowMs);
    else this.follower.take(place, nowMs);
    set(this.carriage, { "data-lit": this.lit });
    if (place !== before || this.follower.moves) this.moving.changed();
    const drawn = JSON.stringify([this.range(), this.low, this.high, this.marks.length, this.zones]);
    if (drawn === this.drawn) return;
    this.drawn = drawn;
    const count = this.marks.length;
    set(this.element, { "aria-label": count ? `${this.name}, ${count} ${count > 1 ? "spots" : "spot"}` : this.name });
    this.surface.changed();
    this.moving.changed();
  }

  /** @returns {[number, number]} the positions at both ends of the picture */
  range() {
    const all = [...this.zones.flatMap((zone) => [zone.low, zone.high]), ...this.marks];
    const ends = all.filter((end) => typeof end === "number");
    const least = Math.min(this.low ?? this.least, ...ends);
    const most = Math.max(this.high ?? this.most, ...ends);
    if (this.low !== null && this.high !== null) return [least, most];
    const [low, high] = roundRange(least, Math.max(most, least + LEAST_SPAN));
    return [this.low ?? low, this.high ?? high];
  }

  /**
   * @param {CanvasRenderingContext2D} context
   * @param {number} width
   * @param {number} height
   * @param {Colours} colours
   */
  draw(context, width, height, colours) {
    const [low, high] = this.range();
    const inside = width - 2 * MARGIN;
    const x = (/** @type {number} */ at) => MARGIN + ((at - low) / (high - low || 1)) * inside;
    const y = Math.round(0.5 * height);
    context.font = `11px ${colours.font}`;
    this.scale(context, x, y, low, high, inside, colours);
    this.drawZones(context, x, y, width, colours);
    context.fillStyle = colours.trigger;
    for (const mark of this.marks) {
      context.beginPath();
      context.arc(x(mark), y + 3, 2.5, 0, 2 * Math.PI);
      context.fill();
    }
    for (const [at, side] of /** @type {[number | null, number][]} */ ([
      [this.low, -1],
      [this.high, 1],
    ])) {
      if (at !== null) hardStop(context, x(at) + (side * CARRIAGE) / 2, y, side, colours);
    }
  }

  /**
   * @param {CanvasRenderingContext2D} context
   * @param {(place: number) => number} x
   * @param {number} y
   * @param {number} low
   * @param {number} high
   * @param {number} inside
   * @param {Colours} colours
   */
  scale(context, x, y, low, high, inside, colours) {
    context.fillStyle = colours.body;
    context.strokeStyle = colours.line;
    context.beginPath();
    context.roundRect(MARGIN - CARRIAGE / 2, y - 3, inside + CARRIAGE, 6, 2);
    context.fill();
    context.stroke();
    const parts = Math.max(Math.floor(inside / 70), 1);
    const all = ticks(low, high, parts);
    const step = niceStep(high - low, parts);
    context.beginPath();
    for (const at of ticks(low, high, 5 * parts)) {
      const long = Math.abs(at / step - Math.round(at / step)) < 1e-6;
      context.moveTo(Math.round(x(at)) + 0.5, y + 13);
      context.lineTo(Math.round(x(at)) + 0.5, y + (long ? 20 : 16));
    }
    context.strokeStyle = colours.muted;
    context.stroke();
    context.fillStyle = colours.muted;
    context.textAlign = "center";
    context.textBaseline = "top";
    all.forEach((at, n) => {
      const unit = n === all.length - 1 && this.unit && this.unit !== "steps" ? ` ${this.unit}` : "";
      context.fillText(digitsOf(at, 7) + unit, x(at), y + 22);
    });
  }

  /**
   * @param {CanvasRenderingContext2D} context
   * @param {(place: number) => number} x
   * @param {number} y
   * @param {number} width
   * @param {Colours} colours
   */
  drawZones(context, x, y, width, colours) {
    for (const zone of this.zones) {
      const from = Math.max(zone.low === null ? 4 : x(zone.low), 4);
      const to = Math.max(Math.min(zone.high === null ? width - 4 : x(zone.high), width - 4), from + 3);
      context.beginPath();
      context.roundRect(from, y - 25, to - from, 5, 2);
      context.strokeStyle = zone.closed ? colours.high : colours.muted;
      context.fillStyle = zone.closed ? colours.high : colours.ground;
      context.fill();
      context.stroke();
      context.fillStyle = zone.closed ? colours.ink : colours.muted;
      context.textBaseline = "bottom";
      const middle = (from + to) / 2;
      const half = context.measureText(zone.name).width / 2;
      context.textAlign = "center";
      context.fillText(zone.name, Math.min(Math.max(middle, half + 4), width - half - 4), y - 27);
    }
  }
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {number} x
 * @param {number} y
 * @param {number} side
 * @param {Colours} colours
 */
function hardStop(context, x, y, side, colours) {
  context.strokeStyle = colours.ink;
  context.lineWidth = 2;
  context.beginPath();
  context.moveTo(x, y - 15);
  context.lineTo(x, y + 10);
  context.stroke();
  context.lineWidth = 1;
  context.beginPath();
  for (let n = 0; n < 5; n++) {
    context.moveTo(x, y - 13 + 5 * n);
    context.lineTo(x + 6 * side, y - 9 + 5 * n);
  }
  context.strokeStyle = colours.muted;
  context.stroke();
}
