/**
 * The requests of the scope: windows, the trigger, and the readings at the cursors; one at a time.
 */

import { say } from "./dom.js";
import { Readings } from "./scope_readings.js";
import { SECOND, instantText } from "./units.js";
import { decoded } from "./window_data.js";

/** @typedef {import("./link.js").Link} Link */
/** @typedef {import("./window_data.js").Trace} Trace */

const FOLLOW_MS = 100; // between two windows while time passes
const UNSEEN_MS = 1000; // between two windows while off-screen
const SEARCH_PS = 20 * SECOND; // minimum time to search back for a trigger
export const SETTLE_MS = 150; // after which a cursor at rest is read exactly
export const SHARE = 0.3; // fraction of the window before the trigger

/**
 * Return the smallest time step that a number resolves at an instant: 1 ps in the first hours.
 * @param {number} ps
 * @returns {number}
 */
export function least(ps) {
  return Math.max(1, Math.ceil(ps * 2 * Number.EPSILON));
}

export class Feed {
  /** @param {Link} link */
  constructor(link) {
    this.link = link;
    this.start = 0;
    this.span = 2 * SECOND;
    this.following = true;
    /** @type {Map<string, Trace>} */
    this.traces = new Map();
    /** @type {(number | null)[]} */
    this.cursors = [null, null];
    /** Instant of the trigger. @type {number | null} */
    this.found = null;
    this.readings = new Readings();
    this.busy = false;
    this.stale = true; // the picture needs a window that has not been requested
    this.askedMs = 0;
    this.askedPs = -1; // end of the last window
    this.movedMs = 0; // time of the last cursor movement
    this.closed = false;
    this.problem = document.createElement("p");
    /** @type {import("./scope_signals.js").Signals} */
    this.signals;
    /** @type {import("./scope_trigger.js").Trigger} */
    this.trigger;
  }

  /** @returns {boolean} whether the picture is visible */
  get seen() {
    return false;
  }

  /** @returns {number} px of the window */
  get inner() {
    return 0;
  }

  /** Show the received data. */
  read() {}

  /** @param {unknown} error */
  tell(error) {
    say(this.problem, error instanceof Error ? error.message : String(error));
    this.problem.hidden = false;
  }

  /** Send the next request, unless one is in progress. */
  async pump() {
    if (this.busy || this.closed || document.hidden || !this.link.connected) return;
    if (!this.seen && performance.now() - this.askedMs < UNSEEN_MS) return;
    const job = this.job();
    if (!job) return;
    this.busy = true;
    try {
      await job.call(this);
    } catch (error) {
      if (!this.closed) this.tell(error);
    }
    this.busy = false;
    if (this.stale) this.pump();
  }

  /** @returns {(() => Promise<void>) | null} */
  job() {
    const [nowMs, nowPs] = [performance.now(), this.link.timePs];
    const due = nowMs - this.askedMs >= FOLLOW_MS;
    const passes = nowPs !== this.askedPs && (this.following || this.start + this.span > this.askedPs);
    if (this.signals.chosen.length && (this.stale || (passes && due))) return this.askWindow;
    if (this.movedMs && nowMs - this.movedMs >= SETTLE_MS) return this.askCursors;
    return null;
  }

  async askWindow() {
    this.stale = false;
    this.askedMs = performance.now();
    const { following, span } = this;
    const nowPs = (this.askedPs = this.link.timePs);
    const start = following ? await this.aim(nowPs) : this.start;
    if (start === null) return;
    const stop = Math.min(Math.round(start + span), nowPs);
    const from = Math.round(start);
    const signals = [...this.signals.chosen];
    const columns = Math.max(Math.round((this.inner * (stop - from)) / span), 2);
    const reply = stop > from ? await this.link.request({ do: "window", signals, start: from, stop, columns }) : { signals: {} };
    for (const [name, signal] of Object.entries(reply.signals)) {
      if (this.signals.chosen.includes(name)) this.traces.set(name, decoded(signal, from, stop));
    }
    // the window advances when its data have arrived, unless the user has moved it meanwhile
    if (following && this.following && this.span === span) this.start = start;
    this.problem.hidden = true;
    this.read();
  }

  /**
   * Return the start of the window while time passes: at the end, or around the last trigger; null if it is already there.
   * @param {number} nowPs
   * @returns {Promise<number | null>}
   */
  async aim(nowPs) {
    const sought = this.trigger.sought();
    if (sought && !this.trigger.holds(this.link.view)) {
      const stop = Math.round(nowPs - (1 - SHARE) * this.span);
      const back = Math.max(10 * this.span, SEARCH_PS);
      // do not search again before the last window
      const start = Math.round(Math.max(this.found !== null && this.found < stop ? this.found : stop - back, 0));
      const reply = stop > start ? await this.link.request({ do: "find", on: sought, start, stop, last: true }) : {};
      const before = this.found;
      const found = typeof reply.found_ps === "number" ? reply.found_ps : before;
      this.found = found;
      say(this.trigger.state, found === null ? "waiting" : `at ${instantText(found, this.span / 1000)}`);
      if (found !== null) {
        const at = Math.max(found - SHARE * this.span, 0);
        return at === this.start && found === before && this.complete() ? null : at;
      }
      if (this.trigger.mode.value === "normal") return null;
    }
    return Math.max(nowPs - this.span, 0);
  }

  /** @returns {boolean} whether the data of the whole window have arrived */
  complete() {
    return this.signals.chosen.every((name) => {
      const trace = this.traces.get(name);
      return trace !== undefined && trace.start <= Math.round(this.start) && trace.stop >= Math.round(this.start + this.span);
    });
  }

  /** Read the levels and values at the cursors exactly, even outside the picture. */
  async askCursors() {
    const movedMs = this.movedMs;
    for (const [n, ps] of this.cursors.entries()) {
      if (ps === null || this.readings.exact[n]?.ps === ps || ps + least(ps) > this.link.timePs) continue;
      const signals = [...this.signals.chosen];
      const stop = ps + least(ps);
      const reply = await this.link.request({ do: "window", signals, start: ps, stop, columns: 1 });
      const traces = new Map(Object.entries(reply.signals).map(([name, one]) => [name, decoded(one, ps, stop)]));
      this.readings.exact[n] = { ps, traces };
    }
    if (this.movedMs === movedMs) this.movedMs = 0;
    this.read();
  }
}
