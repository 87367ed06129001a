/**
 * The registers of a chip, with the names and units of its manual; changed values light up.
 */

import { h, say } from "./dom.js";
import { grouped, shown } from "./format.js";

const LIT_MS = 300;
const LONG_LETTER = 3; // a command with a name, such as SET_POS, would only repeat the register's name

/**
 * Show the registers of a chip.
 * @param {Record<string, any>} sheet of the chip
 * @param {string} chipName
 * @param {HTMLElement} root
 * @returns {{update: (view: any) => void, close: () => void}}
 */
export function registers(sheet, chipName, root) {
  /** Rows of the sheet, by name. @type {Map<string, any>} */
  const described = new Map((sheet.registers ?? []).map((/** @type {any} */ one) => [one.name, one]));
  const head = h("tr");
  const body = h("tbody");
  const table = h("table", { class: "registers", "aria-label": `Registers of ${chipName}` }, h("thead", {}, head), body);
  root.append(table);
  /** The cells of each register: one, or one for each axis. @type {Map<string, HTMLElement[]>} */
  let cells = new Map();
  let shape = "";

  /** @param {any} chip */
  function build(chip) {
    const axes = many(chip) ? chip.axes : [];
    const whole = Object.keys(chip.registers ?? {});
    const names = axes.length ? [...new Set([...Object.keys(axes[0].registers ?? {}), ...whole])] : whole;
    const columns = axes.length ? axes.map((/** @type {any} */ _axis, /** @type {number} */ n) => `Axis ${n + 1}`) : ["Value"];
    table.classList.toggle("many", axes.length > 0);
    head.replaceChildren(
      h("th", { scope: "col" }, "Register"),
      ...columns.map((/** @type {string} */ column) => h("th", { scope: "col", class: "number" }, column)),
      h("th", { scope: "col", class: "unit" }, "Unit"),
      h("th", { scope: "col", class: "says" }, "Meaning"),
    );
    cells = new Map();
    body.replaceChildren(
      ...names.map((name) => {
        const one = described.get(name) ?? {};
        const own = columns.map(() => h("td", { class: "number" }));
        cells.set(name, own);
        const bits = one.bits ? ` (${one.bits} bits)` : "";
        return h("tr", { title: one.says ? `${one.says}${bits}` : null },
          h("th", { scope: "row" },
            h("span", { class: "register-name" }, name.replaceAll("_", " ")),
            one.letter && one.letter.length < LONG_LETTER && h("span", { class: "letter" }, one.letter)),
          ...own,
          h("td", { class: "unit" }, one.unit ?? ""),
          h("td", { class: "says" }, one.says ?? ""));
      }),
    );
  }

  return {
    update(view) {
      const chip = view.chips?.[chipName];
      if (!chip) return;
      const now = `${many(chip) ? chip.axes.length : 1} ${Object.keys(chip.registers ?? {}).join()}`;
      const fresh = now !== shape;
      if (fresh) {
        shape = now;
        build(chip);
      }
      for (const [name, own] of cells) {
        own.forEach((cell, index) => {
          const value = many(chip) ? chip.axes[index]?.registers?.[name] : chip.registers[name];
          if (say(cell, shown(value)) && !fresh) flash(cell);
          if (typeof value === "number" && Number.isInteger(value) && value >= 0) {
            cell.title = `${grouped(value)} = ${value.toString(16).toUpperCase()} hexadecimal`;
          }
        });
      }
    },
    close() {
      root.replaceChildren();
    },
  };
}

/**
 * Return whether a chip has several axes.
 * @param {any} chip
 * @returns {boolean}
 */
function many(chip) {
  return (chip.axes?.length ?? 0) > 1;
}

/** Time until which each cell is lit. @type {Map<HTMLElement, number>} */
const lit = new Map();
/** @type {ReturnType<typeof setTimeout> | undefined} */
let timer;

/**
 * Light up a cell, and let it fade after its last change; frequent changes only extend the time.
 * @param {HTMLElement} cell
 */
export function flash(cell) {
  if (!lit.has(cell)) cell.setAttribute("data-lit", "");
  lit.set(cell, performance.now() + LIT_MS);
  timer ??= setTimeout(fade, LIT_MS);
}

function fade() {
  const nowMs = performance.now();
  for (const [cell, untilMs] of lit) {
    if (untilMs > nowMs) continue;
    cell.removeAttribute("data-lit");
    lit.delete(cell);
  }
  timer = lit.size ? setTimeout(fade, LIT_MS) : undefined;
}
