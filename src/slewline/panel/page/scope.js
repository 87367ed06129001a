/**
 * The scope: pins and quantities over time, as a logic analyser shows them.
 *
 * The server returns a window with as many columns as the picture, so an hour takes no longer than a second.  Never
 * more than one request is in progress; meanwhile the picture moves with the existing data.
 */

import { h, say } from "./dom.js";
import { control, set } from "./elements.js";
import { saveImage, saveText } from "./scope_save.js";
import { CURSOR_NAMES, drawScope, gutter, pictureHeight } from "./scope_draw.js";
import { Feed, SETTLE_MS, SHARE, least } from "./scope_feed.js";
import { onPointers } from "./scope_pointer.js";
import { Signals, firstSignals } from "./scope_signals.js";
import { Trigger } from "./scope_trigger.js";
import { Surface, currentColours } from "./surface.js";
import { SECOND, instantText, timeText } from "./units.js";
import { nearestEdge, zoomed } from "./window_data.js";

/** @typedef {import("./link.js").Link} Link */

const LEAST_PS = 1000;
const MOST_PS = 30 * 86400 * SECOND;
const KEEP = "1 h";
const SNAP_PX = 6;
const ZOOM = 1.6;
const PAN = 0.2;

/**
 * Show the scope.
 * @param {Link} link
 * @param {HTMLElement} root
 * @returns {{update: () => void, close: () => void}}
 */
export function scope(link, root) {
  return new Scope(link, root);
}

class Scope extends Feed {
  /**
   * @param {Link} link
   * @param {HTMLElement} root
   */
  constructor(link, root) {
    super(link);
    this.active = 0;
    this.recorded = "";
    this.signals = new Signals((chosen) => this.shown(chosen));
    this.trigger = new Trigger(() => this.retrigger(), (last) => this.seek(last));
    this.follow = control("Follow", () => this.toggle(), { "aria-pressed": "true" });
    this.range = h("span", { class: "scope-span" });
    set(this.problem, { class: "draw-problem", role: "alert", hidden: true });
    this.canvas = h("canvas", { class: "scope-canvas", tabindex: "0", role: "img", "aria-label": "Scope" });
    this.element = this.build();
    root.replaceChildren(this.element);
    this.surface = new Surface(this.canvas, (context, width, height, colours) => {
      this.fit(width);
      drawScope(context, width, height, colours, this.picture());
    });
    onPointers(this.canvas, {
      // two fingers change the length of a following window; one finger stops the following
      pan: (px, pinched) => !(pinched && this.following) && this.pan(-px / this.inner),
      zoom: (factor, at) => this.zoom(factor, this.time(at)),
      grip: (at, within) => this.grip(at, within),
      move: (cursor, at) => this.place(cursor, this.snapped(at)),
      tap: (at) => this.tap(at),
    });
    this.canvas.addEventListener("keydown", (event) => this.key(event));
    this.visible = () => this.pump();
    document.addEventListener("visibilitychange", this.visible);
    this.end = link.on("branch", () => {
      this.recorded = ""; // a checkpoint older than the page has no recording yet
      this.changed();
    });
    this.learn();
  }

  build() {
    const cursor = (/** @type {number} */ n) =>
      control(CURSOR_NAMES[n], () => this.toggleCursor(n), { class: "cursor-button", "aria-label": `Cursor ${CURSOR_NAMES[n]}` });
    this.buttons = [cursor(0), cursor(1)];
    const bar = h(
      "div", { class: "scope-bar", role: "toolbar", "aria-label": "Scope" },
      this.signals.element, this.follow,
      h("span", { class: "scope-group" },
        control("\u2212", () => this.zoom(ZOOM), { "aria-label": "Longer window" }), this.range,
        control("+", () => this.zoom(1 / ZOOM), { "aria-label": "Shorter window" }),
        control("All", () => this.all(), { "aria-label": "Show the whole run" })),
      h("span", { class: "scope-group" }, "cursors ", ...this.buttons),
      h("span", { class: "scope-group" },
        "save ",
        control("VCD", () => this.save("vcd"), { "aria-label": "Save as VCD" }),
        control("CSV", () => this.save("csv"), { "aria-label": "Save as CSV" }),
        control("PNG", () => this.save("png"), { "aria-label": "Save as PNG" })),
    ); // prettier-ignore
    return h("div", { class: "scope" }, h("div", { class: "scope-tools" }, bar, this.trigger.element), this.problem, this.canvas, this.readings.element);
  }

  close() {
    this.closed = true;
    document.removeEventListener("visibilitychange", this.visible);
    this.end();
    this.signals.close();
    this.surface.close();
    this.element.remove();
  }

  // ------------------------------------------------------------------------------------------------------ what there is
  async learn() {
    try {
      const signals = await this.link.request({ do: "signals" });
      if (this.closed) return;
      this.recorded = "";
      this.signals.offer(signals);
      this.trigger.offer(this.signals.pins, this.signals.quantities, this.signals.owners);
      if (this.signals.chosen.length) {
        this.shown(this.signals.chosen);
        return;
      }
      const chip = Object.keys(this.link.view.chips ?? {})[0] ?? this.signals.owners[0];
      if (chip === undefined) return;
      const { sheet } = await this.link.request({ do: "describe", chip });
      if (!this.closed) this.signals.show(firstSignals(chip, sheet.pins, this.signals.quantities));
    } catch (error) {
      this.tell(error);
    }
  }

  /** @param {string[]} chosen */
  shown(chosen) {
    for (const name of this.traces.keys()) if (!chosen.includes(name)) this.traces.delete(name);
    this.fit(this.canvas.clientWidth);
    const pins = this.pins();
    const record = pins.join(" ");
    if (pins.length && record !== this.recorded) {
      this.recorded = record;
      this.link.request({ do: "record", pins, keep: KEEP }).catch((error) => {
        if (this.link.writes) this.tell(error); // a read-only page shows the recordings of other clients
      });
    }
    this.changed();
  }

  /** @returns {string[]} the displayed pins */
  pins() {
    return this.signals.chosen.filter((name) => !this.signals.quantities.includes(name));
  }

  picture() {
    return {
      start: this.start,
      stop: this.start + this.span,
      signals: this.signals.chosen,
      traces: this.traces,
      quantities: new Set(this.signals.quantities),
      cursors: this.cursors,
      active: this.active,
      found: this.trigger.on ? this.found : null,
      now: this.link.timePs,
    };
  }

  /**
   * Set the height of the picture to that of its lanes.
   * @param {number} width
   */
  fit(width) {
    const height = `${Math.max(pictureHeight(this.picture(), width), 80)}px`;
    if (width && this.canvas.style.height !== height) this.canvas.style.height = height;
  }

  // ----------------------------------------------------------------------------------------------------------- requests
  changed() {
    this.stale = true;
    say(this.range, timeText(this.span, 3));
    set(this.follow, { "aria-pressed": String(this.following) });
    this.surface.changed();
    this.pump();
  }

  /** Draw changes; called for every frame in which something may have changed. */
  update() {
    this.pump();
  }

  retrigger() {
    this.found = null;
    say(this.trigger.state, "");
    this.changed();
  }

  /** @param {boolean} last */
  async seek(last) {
    const sought = this.trigger.sought();
    if (!sought) return;
    const stop = this.start + this.span;
    const inside = this.found !== null && this.found >= this.start && this.found <= stop;
    const from = Math.round(inside ? /** @type {number} */ (this.found) : this.start + SHARE * this.span);
    const window = last ? { start: 0, stop: Math.max(from - least(from), 0) } : { start: from + least(from), stop: this.link.timePs };
    try {
      const { found_ps: found } = await this.link.request({ do: "find", on: sought, ...window, last });
      say(this.trigger.state, typeof found === "number" ? `at ${instantText(found, this.span / 1000)}` : "none found");
      if (typeof found !== "number") return;
      this.found = found;
      this.following = false;
      this.start = Math.max(found - SHARE * this.span, 0);
      this.changed();
    } catch (error) {
      this.tell(error);
    }
  }

  // ------------------------------------------------------------------------------------------------------------- window
  /** @returns {boolean} */
  get seen() {
    return this.surface.seen;
  }

  /** @returns {number} px of the window */
  get inner() {
    const width = this.canvas.clientWidth || 800;
    return width - gutter(width);
  }

  /**
   * @param {number} at px from the left edge of the picture
   * @returns {number} ps
   */
  time(at) {
    return this.start + ((at - gutter(this.canvas.clientWidth)) / this.inner) * this.span;
  }

  toggle() {
    this.following = !this.following;
    this.changed();
  }

  /**
   * @param {number} factor
   * @param {number} [at] the instant that keeps its place
   */
  zoom(factor, at) {
    const end = Math.min(this.start + this.span, Math.max(this.link.timePs, this.start + 1));
    const middle = this.following ? (this.trigger.on ? this.start + SHARE * this.span : end) : this.start + this.span / 2;
    const fixed = this.following ? middle : (at ?? middle);
    const [start, stop] = zoomed(this.start, this.start + this.span, factor, fixed, LEAST_PS, MOST_PS);
    [this.start, this.span] = [start, stop - start];
    this.changed();
  }

  /** @param {number} share fraction of the window */
  pan(share) {
    if (!share) return;
    this.following = false;
    const last = Math.max(this.link.timePs - 0.1 * this.span, 0);
    this.start = Math.min(Math.max(this.start + share * this.span, 0), last);
    this.changed();
  }

  all() {
    this.following = false;
    [this.start, this.span] = [0, Math.max(this.link.timePs, LEAST_PS)];
    this.changed();
  }

  // ------------------------------------------------------------------------------------------------------------ cursors
  /**
   * @param {number} at px
   * @param {number} within px
   * @returns {number | null}
   */
  grip(at, within) {
    const left = gutter(this.canvas.clientWidth);
    const distances = this.cursors.map((ps) => {
      return ps === null ? Infinity : Math.abs(left + ((ps - this.start) / this.span) * this.inner - at);
    });
    const nearest = distances[this.active] <= within ? this.active : distances.indexOf(Math.min(...distances));
    return distances[nearest] <= within ? nearest : null;
  }

  /**
   * Return the instant at a position in the picture, or that of an edge nearby.
   * @param {number} at px
   * @returns {number}
   */
  snapped(at) {
    const ps = this.time(at);
    const within = (SNAP_PX / this.inner) * this.span;
    let best = Infinity;
    for (const trace of this.traces.values()) {
      const edge = trace.kind === "pin" ? nearestEdge(trace, ps, within) : null;
      if (edge !== null && Math.abs(edge - ps) < Math.abs(best - ps)) best = edge;
    }
    return best < Infinity ? best : ps;
  }

  /** @param {number} at px */
  tap(at) {
    this.canvas.focus({ preventScroll: true });
    if (at < gutter(this.canvas.clientWidth)) return;
    const free = this.cursors.indexOf(null);
    this.place(free >= 0 ? free : this.active, this.snapped(at));
  }

  /**
   * @param {number} n
   * @param {number | null} ps
   */
  place(n, ps) {
    this.active = n;
    this.cursors[n] = ps === null ? null : Math.max(Math.round(ps), 0);
    this.movedMs = performance.now();
    setTimeout(() => this.pump(), SETTLE_MS + 10);
    this.read();
  }

  /** @param {number} n */
  toggleCursor(n) {
    const ps = this.cursors[n];
    const inside = ps !== null && ps >= this.start && ps <= this.start + this.span;
    this.place(n, inside ? null : this.start + (n ? 0.6 : 0.4) * this.span);
  }

  read() {
    this.surface.changed();
    this.buttons?.forEach((one, n) => set(one, { "aria-pressed": String(this.cursors[n] !== null) }));
    this.readings.show(this.cursors, this.signals.chosen, this.traces, this.span / this.inner);
    const end = instantText(this.start + this.span, this.span / 100);
    const label = `Scope: ${this.signals.chosen.join(", ") || "no signals"}; ${instantText(this.start, this.span / 100)} to ${end}`;
    if (!this.following) set(this.canvas, { "aria-label": label });
  }

  /** @param {KeyboardEvent} event */
  key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const point = this.span / this.inner;
    const nudge = (/** @type {number} */ by) => {
      this.place(this.active, (this.cursors[this.active] ?? this.start + this.span / 2) + by * point);
    };
    /** @type {Record<string, () => void>} */
    const keys = {
      "+": () => this.zoom(1 / ZOOM, this.cursors[this.active] ?? undefined),
      "-": () => this.zoom(ZOOM, this.cursors[this.active] ?? undefined),
      ArrowLeft: () => (event.shiftKey ? nudge(-1) : this.pan(-PAN)),
      ArrowRight: () => (event.shiftKey ? nudge(1) : this.pan(PAN)),
      PageUp: () => this.pan(-1),
      PageDown: () => this.pan(1),
      Home: () => this.pan(-Infinity),
      End: () => !this.following && this.toggle(),
      f: () => this.toggle(),
      a: () => this.place(0, this.cursors[0] ?? this.start + 0.4 * this.span),
      b: () => this.place(1, this.cursors[1] ?? this.start + 0.6 * this.span),
      p: () => this.seek(true),
      n: () => this.seek(false),
      Escape: () => [0, 1].forEach((n) => this.place(n, null)),
    };
    const work = keys[event.key === "=" ? "+" : event.key];
    if (!work) return;
    event.preventDefault();
    work();
  }

  // --------------------------------------------------------------------------------------------------------------- save
  /** @param {"vcd" | "csv" | "png"} form */
  async save(form) {
    try {
      if (form === "png") {
        const { clientWidth: width, clientHeight: height } = this.canvas;
        const colours = currentColours();
        await saveImage(width, height, colours.ground, (context) => drawScope(context, width, height, colours, this.picture()));
        return;
      }
      const signals = this.pins();
      if (!signals.length) throw new Error("VCD and CSV contain pins only, and none is shown. Select a pin.");
      const [start, stop] = [Math.round(this.start), Math.min(Math.round(this.start + this.span), this.link.timePs)];
      const { text } = await this.link.request({ do: "export", signals, start, stop, form });
      saveText(text, `scope.${form}`, form === "csv" ? "text/csv" : "text/plain");
    } catch (error) {
      this.tell(error);
    }
  }
}
