/**
 * The stored program of a chip: addresses, bytes and text, the current instruction, and breakpoints.
 *
 * Only the visible rows are elements, so a program may have any length.
 */

import { h, say } from "./dom.js";

/** @typedef {import("./link.js").Link} Link */
/** @typedef {import("./breakpoints.js").Breakpoints} Breakpoints */
/** @typedef {{address: number, bytes: string, text: string, label?: string}} Row */

const ROW_PX = 22; // as in style.css
const MORE = 4; // rows above and below the visible ones

/**
 * Show the program of a chip.
 * @param {Link} link
 * @param {string} chipName
 * @param {HTMLElement} root
 * @param {Breakpoints} breakpoints
 * @returns {{update: (view: any) => void, close: () => void}}
 */
export function listing(link, chipName, root, breakpoints) {
  /** @type {Row[]} */
  let rows = [];
  /** @type {Map<number, number>} */
  let places = new Map();
  let program = -1;
  let active = 0;
  /** @type {number | null} */
  let counter = null;
  let closed = false;
  /** The rows that exist as elements, by index. @type {Map<number, HTMLElement>} */
  const shownRows = new Map();

  const sheet = h("div", { class: "listing-rows", role: "presentation" });
  const box = h(
    "div",
    {
      class: "listing", role: "listbox", tabindex: 0, "aria-multiselectable": "true",
      "aria-label": `Program of ${chipName}: Enter sets or removes a breakpoint`,
      scroll: draw, keydown: key, click: pressed, focus: draw, blur: draw,
    },
    sheet,
  );
  const empty = h("p", { class: "quiet empty" }, "No program is stored.");
  root.append(box, empty);
  const forget = () => draw();
  breakpoints.listeners.add(forget);
  const size = new ResizeObserver(() => draw());
  size.observe(box);

  async function load() {
    try {
      const reply = await link.request({ do: "listing", chip: chipName });
      if (closed) return;
      rows = reply.rows;
      shownRows.clear();
      sheet.replaceChildren();
      places = new Map(rows.map((row, index) => [row.address, index]));
      active = Math.min(active, Math.max(0, rows.length - 1));
      counter = reply.counter ?? null;
      sheet.style.height = `${rows.length * ROW_PX}px`;
      box.hidden = !rows.length;
      empty.hidden = rows.length > 0;
      follow();
      draw();
    } catch (error) {
      box.hidden = true;
      empty.hidden = false;
      say(empty, /** @type {Error} */ (error).message);
    }
  }

  /** @param {number} index */
  function reveal(index) {
    const top = index * ROW_PX;
    if (top < box.scrollTop) box.scrollTop = top;
    else if (top + ROW_PX > box.scrollTop + box.clientHeight) box.scrollTop = top + ROW_PX - box.clientHeight;
  }

  function follow() {
    const place = counter === null ? undefined : places.get(counter);
    if (place !== undefined && document.activeElement !== box) reveal(place);
  }

  /** @param {number} index */
  function toggle(index) {
    if (link.writes && rows[index]) breakpoints.toggle(chipName, rows[index].address);
  }

  /** @param {Event} event */
  function pressed(event) {
    const row = /** @type {HTMLElement} */ (event.target).closest("[data-index]");
    if (!row) return;
    active = Number(/** @type {HTMLElement} */ (row).dataset.index);
    toggle(active);
    draw();
  }

  /** @param {Event} event */
  function key(event) {
    const page = Math.max(1, Math.floor(box.clientHeight / ROW_PX) - 1);
    const name = /** @type {KeyboardEvent} */ (event).key;
    /** @type {Record<string, number>} */
    const moves = { ArrowDown: 1, ArrowUp: -1, PageDown: page, PageUp: -page, Home: -rows.length, End: rows.length };
    if (name in moves) {
      active = Math.max(0, Math.min(rows.length - 1, active + moves[name]));
      reveal(active);
      draw();
    } else if (name === "Enter" || name === " ") {
      toggle(active);
    } else {
      return;
    }
    event.preventDefault();
  }

  function draw() {
    const first = Math.max(0, Math.floor(box.scrollTop / ROW_PX) - MORE);
    const last = Math.min(rows.length, Math.ceil((box.scrollTop + box.clientHeight) / ROW_PX) + MORE);
    for (const [index, element] of shownRows) {
      if (index >= first && index < last) continue;
      element.remove();
      shownRows.delete(index);
    }
    for (let index = first; index < last; index++) {
      let element = shownRows.get(index);
      if (!element) {
        element = rowElement(rows[index], index);
        shownRows.set(index, element);
        sheet.append(element);
      }
      dress(element, rows[index], index);
    }
    const current = sheet.querySelector("[data-active]");
    if (current) box.setAttribute("aria-activedescendant", current.id);
    else box.removeAttribute("aria-activedescendant");
  }

  /**
   * @param {Row} row
   * @param {number} index
   */
  function rowElement(row, index) {
    const element = h(
      "div",
      { class: "listing-row", role: "option", id: `${chipName}-row-${index}`, "data-index": index },
      h("span", { class: "mark" }),
      h("span", { class: "address" }, String(row.address)),
      h("span", { class: "bytes" }, row.bytes),
      h("span", { class: "text" }, row.label && h("b", {}, `${row.label} `), row.text),
    );
    element.style.top = `${index * ROW_PX}px`;
    return element;
  }

  /**
   * @param {HTMLElement} element
   * @param {Row} row
   * @param {number} index
   */
  function dress(element, row, index) {
    const stops = breakpoints.at(chipName, row.address);
    const isHere = row.address === counter;
    const label = `${row.address}: ${row.text}${stops ? ", breakpoint" : ""}${isHere ? ", current" : ""}`;
    element.setAttribute("aria-selected", String(stops));
    element.setAttribute("aria-label", label);
    element.toggleAttribute("data-active", index === active && document.activeElement === box);
    if (isHere) element.setAttribute("aria-current", "step");
    else element.removeAttribute("aria-current");
  }

  const gone = link.on("branch", load);
  return {
    update(view) {
      const chip = view.chips?.[chipName];
      if (!chip) return;
      if (chip.program !== program) {
        program = chip.program;
        load();
      }
      const now = chip.counter ?? null;
      if (now === counter) return;
      counter = now;
      follow();
      draw();
    },
    close() {
      closed = true;
      gone();
      breakpoints.listeners.delete(forget);
      size.disconnect();
      root.replaceChildren();
    },
  };
}
