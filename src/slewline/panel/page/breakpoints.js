/**
 * The breakpoints of the page. The control port takes all of them in one request, so they are kept in one place.
 */

import { button, choices, field, h, select } from "./dom.js";
import { grouped, wholeNumber } from "./format.js";

/** @typedef {import("./link.js").Link} Link */
/** @typedef {Record<string, any>} Breakpoint as a request has it */

/** @type {Record<string, string>} */
const KINDS = { pin: "Pin", register: "Register", position: "Position", address: "Instruction", finding: "Finding" };
const HINTS = { pin: "x.slew", register: "name, or name=80", position: "400", address: "7", finding: "" };

export class Breakpoints {
  /**
   * @param {Link} link
   * @param {(error: Error) => void} fail called with an error of a breakpoint
   */
  constructor(link, fail) {
    this.link = link;
    this.fail = fail;
    /** @type {Breakpoint[]} */
    this.all = [];
    /** Their names on the server. @type {string[]} */
    this.names = [];
    /** @type {Set<() => void>} */
    this.listeners = new Set();
  }

  /**
   * Replace all breakpoints; if the server refuses one, none is changed.
   * @param {Breakpoint[]} all
   * @returns {Promise<boolean>} whether the server accepted them
   */
  async replace(all) {
    try {
      const reply = await this.link.request({ do: "breakpoints", breakpoints: all });
      this.all = all;
      this.names = reply.breakpoints ?? [];
      for (const listener of this.listeners) listener();
      return true;
    } catch (error) {
      this.fail(/** @type {Error} */ (error));
      return false;
    }
  }

  /**
   * Return whether an instruction has a breakpoint.
   * @param {string} chip
   * @param {number} address
   * @returns {boolean}
   */
  at(chip, address) {
    return this.all.some((one) => one.chip === chip && one.address === address);
  }

  /**
   * Set or remove the breakpoint of an instruction.
   * @param {string} chip
   * @param {number} address
   */
  toggle(chip, address) {
    const others = this.all.filter((one) => one.chip !== chip || one.address !== address);
    this.replace(others.length < this.all.length ? others : [...others, { chip, address }]);
  }

  /** Set all breakpoints again, on a server that may have lost them. */
  renew() {
    if (this.all.length && this.link.writes) this.replace(this.all);
  }
}

/**
 * Return the breakpoint entered in the form; an invalid number is an error.
 * @param {string} kind
 * @param {string} chip
 * @param {string} text
 * @param {string} edge
 * @returns {Breakpoint}
 */
function written(kind, chip, text, edge) {
  const [name, value] = text.split("=").map((part) => part.trim());
  if (kind === "pin") return { pin: name.includes(".") ? name : `${chip}.${name}`, edge };
  if (kind === "finding") return { finding: chip };
  if (kind === "register") return { chip, register: name, ...(value ? { value: wholeNumber(value, `${name} of the register`) } : {}) };
  return { chip, [kind]: wholeNumber(text, kind) };
}

/**
 * Show the list of breakpoints, with a form to add one.
 * @param {Breakpoints} breakpoints
 * @param {HTMLElement} root
 * @returns {{update: (view: any) => void, close: () => void}}
 */
export function breakpointsView(breakpoints, root) {
  const count = h("span", { class: "count" });
  const list = h("ul", { class: "plain breakpoint-list" });
  const kind = select("Kind of breakpoint", KINDS, { change: adapt });
  const chip = select("Chip", {});
  const text = field("Condition", { size: 14, placeholder: HINTS.pin });
  const edge = select("Edge", { any: "any edge", rises: "rises", falls: "falls" });
  const form = h(
    "form",
    { class: "row", submit: add },
    kind, chip, text, edge, h("button", { "data-writes": true }, "Add"),
  );
  const popover = h("details", { class: "popover", keydown: leave },
    h("summary", {}, "Breakpoints", count),
    h("div", { class: "popover-body" },
      list, form,
      h("p", { class: "quiet" }, "Click a line of the program to set a breakpoint there.")));
  root.append(popover);
  document.addEventListener("pointerdown", pressedElsewhere);

  /** @param {Event} event */
  function leave(event) {
    if (/** @type {KeyboardEvent} */ (event).key !== "Escape" || !popover.open) return;
    popover.open = false;
    popover.querySelector("summary")?.focus();
  }

  /** @param {Event} event */
  function pressedElsewhere(event) {
    if (!popover.contains(/** @type {Node} */ (event.target))) popover.open = false;
  }

  function adapt() {
    const chosen = /** @type {keyof HINTS} */ (kind.value);
    edge.hidden = chosen !== "pin";
    text.hidden = chosen === "finding";
    text.placeholder = HINTS[chosen];
  }

  /** @param {Event} event */
  async function add(event) {
    event.preventDefault();
    if (kind.value !== "finding" && !text.value.trim()) return text.focus();
    let one;
    try {
      one = written(kind.value, chip.value, text.value, edge.value);
    } catch (error) {
      return breakpoints.fail(/** @type {Error} */ (error));
    }
    if (await breakpoints.replace([...breakpoints.all, one])) text.value = "";
  }

  function show() {
    count.textContent = breakpoints.all.length ? grouped(breakpoints.all.length) : "";
    list.replaceChildren(
      ...breakpoints.all.map((one, index) => {
        const name = breakpoints.names[index] ?? JSON.stringify(one);
        const others = () => breakpoints.replace(breakpoints.all.filter((other) => other !== one));
        return h("li", {}, h("span", {}, name), button("×", others, { "aria-label": `Remove ${name}`, class: "bare" }));
      }),
      ...(breakpoints.all.length ? [] : [h("li", { class: "quiet" }, "No breakpoints.")]),
    );
  }

  breakpoints.listeners.add(show);
  adapt();
  show();
  let chips = "";
  return {
    update(view) {
      const names = Object.keys(view.chips ?? {});
      if (names.join() === chips) return;
      chips = names.join();
      choices(chip, Object.fromEntries(names.map((name) => [name, name])));
    },
    close() {
      document.removeEventListener("pointerdown", pressedElsewhere);
      breakpoints.listeners.delete(show);
      root.replaceChildren();
    },
  };
}
