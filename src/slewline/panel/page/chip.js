/**
 * The card of a chip: its state, position and velocity, package, registers, program and command line.
 */

import { button, h, say } from "./dom.js";
import { grouped, velocity } from "./format.js";
import { commandLine } from "./commandline.js";
import { listing } from "./listing.js";
import { registers } from "./registers.js";

/** @typedef {import("./link.js").Link} Link */
/** @typedef {{update: (view: any, timePs: number) => void, close: () => void}} View */

const UNSEEN_MS = 500; // between two updates of a card outside the viewport, which a screen reader may be reading

/**
 * Show a chip.
 * @param {Link} link
 * @param {Record<string, any>} sheet
 * @param {string} name
 * @param {HTMLElement} root
 * @param {import("./breakpoints.js").Breakpoints} breakpoints
 * @param {(error: Error) => void} fail
 * @returns {View}
 */
export function chipCard(link, sheet, name, root, breakpoints, fail) {
  const state = h("span", { class: "state" });
  const power = button("", () => {
    const on = link.view.chips?.[name]?.powered === false;
    link.request({ do: "power", chip: name, on }).catch(fail);
  }, { class: "power", "aria-label": `Supply of ${name}` });
  const readings = h("div", { class: "axis-readings" });
  const drawing = h("div", { class: "slot package-slot" });
  const table = h("div", { class: "scroll" });
  const program = h("div", { class: "program" });
  const line = h("div", { class: "line" });
  const id = `chip-${name}`;
  root.append(h("article", { class: "chip-card", "aria-labelledby": id },
    h("header", {},
      h("h2", { id }, name), h("span", { class: "part", title: sheet.title }, sheet.part), state,
      h("span", { class: "grow" }), power),
    readings,
    h("div", { class: "card-body" },
      h("section", { class: "cell cell-package", "aria-label": "Package" }, drawing),
      h("section", { class: "cell cell-registers", "aria-label": "Registers" }, h("h3", {}, "Registers"), table),
      h("section", { class: "cell cell-program", "aria-label": "Program" }, h("h3", {}, "Program"), program)),
    line));

  /** @type {View[]} */
  const views = [registers(sheet, name, table), listing(link, name, program, breakpoints)];
  const cell = program.parentElement;
  if (cell) cell.hidden = !sheet.buffer_bytes; // a chipset stores no program
  const ends = [commandLine(link, sheet, name, line, fail)];
  let closed = false;
  import("./package.js").then(
    (module) => { if (!closed) views.push(module.packageView(link, name, drawing)); },
    () => drawing.parentElement?.remove(),
  );

  /** The numbers of each axis. @type {{position: HTMLElement, velocity: HTMLElement}[]} */
  let axes = [];

  /** @param {number} count */
  function build(count) {
    axes = Array.from({ length: count }, () => ({
      position: h("span", { class: "figure" }), velocity: h("span", { class: "figure" }),
    }));
    readings.replaceChildren(...axes.map((axis, index) => h("dl", { class: "axis-reading" },
      h("div", {}, h("dt", {}, count > 1 ? `Position ${index + 1}` : "Position"), h("dd", {}, axis.position, h("small", {}, " steps"))),
      h("div", {}, h("dt", {}, count > 1 ? `Velocity ${index + 1}` : "Velocity"), h("dd", {}, axis.velocity, h("small", {}, " steps/s"))))));
    readings.classList.toggle("many", count > 1);
  }

  let seen = true;
  let lastMs = -Infinity;
  /** @type {ReturnType<typeof setTimeout> | undefined} */
  let timer;
  const places = new IntersectionObserver((entries) => {
    seen = entries[entries.length - 1].isIntersecting;
    if (seen) later(0);
  });
  places.observe(root);

  /** @param {number} ms */
  function later(ms) {
    clearTimeout(timer);
    timer = setTimeout(() => draw(link.view, link.timePs), ms);
  }

  /**
   * @param {any} view
   * @param {number} timePs
   */
  function draw(view, timePs) {
    clearTimeout(timer);
    lastMs = performance.now();
    const chip = view.chips?.[name];
    if (!chip) return;
    if ((chip.axes?.length ?? 0) !== axes.length) build(chip.axes.length);
    axes.forEach((axis, index) => {
      const own = chip.axes[index];
      say(axis.position, grouped(own.position ?? "–"));
      say(axis.velocity, velocity(own.velocity));
      axis.velocity.closest("dl")?.classList.toggle("moving", own.moving === true);
    });
    const off = chip.powered === false;
    say(state, off ? "no supply" : chip.working ? `executing ${chip.working}` : chip.waiting || (chip.idle ? "idle" : ""));
    state.className = `state ${off ? "off" : chip.working ? "working" : "idle"}`;
    power.hidden = chip.powered === undefined;
    say(power, off ? "Supply off" : "Supply on");
    power.setAttribute("aria-pressed", String(!off));
    for (const one of views) one.update(view, timePs);
  }

  return {
    update(view, timePs) {
      const waitMs = lastMs + UNSEEN_MS - performance.now();
      if (!seen && waitMs > 0) later(waitMs);
      else draw(view, timePs);
    },
    close() {
      closed = true;
      clearTimeout(timer);
      places.disconnect();
      for (const one of [...views, ...ends]) one.close();
      root.replaceChildren();
    },
  };
}
