/**
 * A shaft that turns: the face of a motor with a rotor on it, smooth between views, blurred where the eye could not follow.
 */

import { h } from "./dom.js";
import { Follower } from "./motion.js";
import { Surface, calm } from "./surface.js";

/** @typedef {import("./surface.js").Colours} Colours */

const TURN = 2 * Math.PI;
const PICTURE_MS = 33;
const GHOSTS = 0.35; // radians a picture, above which the pointer leaves a trail
const BLUR = 2.4; // above which only a ring is seen
const SCALE = 40; // ticks round the rotor
const BIG = 5; // of which every fifth one is longer

export class ShaftDial {
  /**
   * @param {string} name for those who do not see it
   */
  constructor(name) {
    this.name = name;
    this.perTurn = 200;
    this.follower = new Follower();
    this.canvas = h("canvas", { class: "shaft-dial", role: "img", "aria-label": name });
    this.surface = new Surface(this.canvas, (...all) => this.draw(...all));
  }

  close() {
    this.surface.close();
  }

  /**
   * Take what a view says.
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
    if (steps !== before || this.follower.moves) this.surface.changed();
  }

  /**
   * @param {CanvasRenderingContext2D} context
   * @param {number} width
   * @param {number} height
   * @param {Colours} colours
   * @param {number} nowMs
   * @returns {boolean}
   */
  draw(context, width, height, colours, nowMs) {
    const size = Math.min(width, height);
    const steps = this.follower.at(nowMs);
    context.translate(width / 2, height / 2);
    face(context, size, colours);
    const sweep = (this.follower.perMs * PICTURE_MS * TURN) / this.perTurn;
    const angle = ((steps % this.perTurn) / this.perTurn) * TURN;
    rotor(context, 0.33 * size, angle, calm() ? 0 : sweep, colours);
    return this.follower.moves && !calm();
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

/**
 * @param {CanvasRenderingContext2D} context
 * @param {number} radius
 * @param {number} angle clockwise from the top
 * @param {number} sweep radians in a picture
 * @param {Colours} colours
 */
function rotor(context, radius, angle, sweep, colours) {
  context.beginPath();
  context.arc(0, 0, radius, 0, TURN);
  context.fillStyle = colours.plate;
  context.fill();
  context.strokeStyle = colours.line;
  context.stroke();
  const size = Math.abs(sweep);
  if (size > BLUR) {
    context.globalAlpha = 0.4;
    context.beginPath();
    context.arc(0, 0, 0.7 * radius, 0, TURN);
    context.lineWidth = 0.44 * radius;
    context.strokeStyle = colours.accent;
    context.stroke();
    context.globalAlpha = 1;
    context.lineWidth = 1;
    chevrons(context, radius, Math.sign(sweep), colours);
  } else {
    const ghosts = size > GHOSTS ? Math.min(Math.ceil(size / 0.12), 20) : 0;
    for (let n = ghosts; n > 0; n--) {
      context.globalAlpha = 0.3 * (1 - n / (ghosts + 1));
      pointer(context, radius, angle - (sweep * n) / ghosts, colours.accent);
    }
    context.globalAlpha = size > GHOSTS ? 0.75 : 1;
    pointer(context, radius, angle, colours.accent);
    context.globalAlpha = 1;
  }
  // the shaft end, with its flat
  context.save();
  if (size <= BLUR) context.rotate(angle);
  context.beginPath();
  context.arc(0, 0, 0.24 * radius, size > BLUR ? 0 : -0.25 * Math.PI, size > BLUR ? TURN : 1.25 * Math.PI);
  context.closePath();
  context.fillStyle = colours.metal;
  context.fill();
  context.strokeStyle = colours.line;
  context.stroke();
  context.restore();
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {number} radius
 * @param {number} angle
 * @param {string} colour
 */
function pointer(context, radius, angle, colour) {
  context.save();
  context.rotate(angle);
  context.beginPath();
  context.moveTo(0, -0.94 * radius);
  context.lineTo(0.1 * radius, -0.5 * radius);
  context.lineTo(-0.1 * radius, -0.5 * radius);
  context.closePath();
  context.fillStyle = colour;
  context.fill();
  context.restore();
}

/**
 * Show which way it turns, where nothing else does.
 * @param {CanvasRenderingContext2D} context
 * @param {number} radius
 * @param {number} sign
 * @param {Colours} colours
 */
function chevrons(context, radius, sign, colours) {
  context.strokeStyle = colours.ink;
  context.lineWidth = 1.5;
  context.beginPath();
  for (let n = 0; n < 3; n++) {
    context.save();
    context.rotate((n / 3) * TURN);
    context.moveTo(-0.08 * sign * radius, -0.82 * radius);
    context.lineTo(0.06 * sign * radius, -0.7 * radius);
    context.lineTo(-0.08 * sign * radius, -0.58 * radius);
    context.restore();
  }
  context.stroke();
  context.lineWidth = 1;
}
