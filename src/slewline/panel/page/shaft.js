/**
 * A shaft that turns: the face of a motor with a rotor, smooth between views, blurred when it turns too fast for the eye.
 *
 * The face is drawn once.  The rotor is an element that is rotated, without redrawing.
 */

import { h } from "./dom.js";
import { set } from "./elements.js";
import { Follower } from "./motion.js";
import { Moving, Surface, calm } from "./surface.js";

/** @typedef {import("./surface.js").Colours} Colours */

const TURN = 2 * Math.PI;
const DEGREES = 360;
const PICTURE_MS = 33;
const TRAIL = 12; // degrees per frame from which the pointer leaves a trail
const BLUR = 135; // degrees per frame from which only a ring is visible
const STEP = 15; // degrees: trails have only a few lengths, because each new length is redrawn
const SCALE = 40; // ticks round the rotor
const BIG = 5; // every fifth one is longer

export class ShaftDial {
  /**
   * @param {string} name accessible name
   */
  constructor(name) {
    this.perTurn = 200;
    this.trail = 0;
    this.follower = new Follower();
    this.rotor = h("div", { class: "shaft-rotor" }, h("div", { class: "shaft-trail" }), h("div", { class: "shaft-pointer" }));
    this.face = h("canvas", { class: "shaft-face" });
    this.element = h("div", { class: "shaft-dial", role: "img", "aria-label": name }, this.face, this.rotor);
    this.surface = new Surface(this.face, (context, width, height, colours) => {
      context.translate(width / 2, height / 2);
      face(context, Math.min(width, height), colours);
    });
    this.moving = new Moving(this.element, (nowMs) => this.turn(nowMs));
  }

  close() {
    this.surface.close();
    this.moving.close();
  }

  /**
   * Take the state from a view.
   * @param {number} steps
   * @param {number} perTurn
   * @param {boolean} jump
   */
  take(steps, perTurn, jump) {
    const nowMs = performance.now();
    const before = this.follower.value;
    this.perTurn = perTurn;
    if (jump || calm()) this.follower.jump(steps, nowMs);
    else this.follower.take(steps, nowMs);
    if (steps !== before || this.follower.moves) this.moving.changed();
  }

  /**
   * @param {number} nowMs
   * @returns {boolean}
   */
  turn(nowMs) {
    const steps = this.follower.at(nowMs);
    const angle = ((steps % this.perTurn) / this.perTurn) * DEGREES;
    this.rotor.style.transform = `rotate(${angle.toFixed(2)}deg)`;
    this.smear(calm() ? 0 : (this.follower.perMs * PICTURE_MS * DEGREES) / this.perTurn);
    return this.follower.moves && !calm();
  }

  /**
   * Show the speed of a rotor that is too fast for the eye.
   * @param {number} sweep degrees per frame
   */
  smear(sweep) {
    const size = Math.abs(sweep);
    const trail = size < TRAIL ? 0 : Math.sign(sweep) * Math.min(Math.ceil(size / STEP) * STEP, BLUR);
    if (trail === this.trail) return;
    this.trail = trail;
    const turns = trail > 0 ? "cw" : "ccw";
    set(this.element, { "data-trail": trail ? turns : null, "data-blur": Math.abs(trail) >= BLUR ? turns : null });
    this.rotor.style.setProperty("--trail", `${2 * Math.abs(trail)}deg`);
  }
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {number} size
 * @param {Colours} colours
 */
function face(context, size, colours) {
  const half = size / 2 - 1;
  context.beginPath();
  context.roundRect(-half, -half, 2 * half, 2 * half, 0.09 * size);
  context.fillStyle = colours.body;
  context.fill();
  context.strokeStyle = colours.line;
  context.lineWidth = 1;
  context.stroke();
  const screw = 0.41 * size;
  for (const [x, y] of [
    [-screw, -screw],
    [screw, -screw],
    [-screw, screw],
    [screw, screw],
  ]) {
    context.beginPath();
    context.arc(x, y, 0.028 * size, 0, TURN);
    context.fillStyle = colours.ground;
    context.fill();
    context.stroke();
  }
  context.beginPath();
  for (let n = 0; n < SCALE; n++) {
    const angle = (n / SCALE) * TURN;
    const [outer, inner] = [0.43 * size, (n % BIG ? 0.405 : 0.375) * size];
    context.moveTo(outer * Math.sin(angle), -outer * Math.cos(angle));
    context.lineTo(inner * Math.sin(angle), -inner * Math.cos(angle));
  }
  context.strokeStyle = colours.muted;
  context.stroke();
}
