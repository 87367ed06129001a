/**
 * The command line of a chip, for commands that a host would send, with history, completion and the manual's help.
 */

import { field, h } from "./dom.js";

/** @typedef {import("./link.js").Link} Link */
/** @typedef {{form: string, name: string, syntax: string, says: string, where?: string}} Command */

const MOST = 200; // lines of the history
const SHOWN = 7; // commands offered

/**
 * Show the command line of a chip.
 * @param {Link} link
 * @param {Record<string, any>} sheet
 * @param {string} chipName
 * @param {HTMLElement} root
 * @param {(error: Error) => void} fail
 * @returns {{close: () => void}}
 */
export function commandLine(link, sheet, chipName, root, fail) {
  /** @type {string[]} */
  const history = [];
  let place = 0; // in the history; its length means the line being typed
  let draft = "";
  /** @type {Command[]} */
  let offered = [];
  let chosen = -1; // of the offered commands

  const helpId = `${chipName}-help`;
  const input = field(`Command for ${chipName}`, {
    "data-writes": true, class: "command", placeholder: example(sheet),
    role: "combobox", "aria-expanded": "false", "aria-controls": helpId, "aria-autocomplete": "list",
    keydown: key, input: offer, blur: hide, focus: offer,
  });
  const help = h("ul", { class: "plain offers", id: helpId, role: "listbox", "aria-label": "Commands", hidden: true });
  root.append(
    h("form", { class: "row command-line", submit: send },
      h("span", { class: "prompt", "aria-hidden": "true" }, "›"), input,
      h("button", { "data-writes": true, "aria-label": `Send to ${chipName}` }, "Send")),
    help,
  );

  /** @param {Event} event */
  async function send(event) {
    event.preventDefault();
    const text = input.value;
    if (!text.trim()) return;
    if (history.at(-1) !== text) history.push(text);
    if (history.length > MOST) history.shift();
    place = history.length;
    input.value = draft = "";
    hide();
    try {
      await link.request({ do: "send", chip: chipName, text });
      if (link.view.pace?.paused) fail(new Error(`${text} is not sent while time is stopped. Press Go.`));
    } catch (error) {
      input.value = text;
      fail(/** @type {Error} */ (error));
    }
  }

  /** @param {Event} event */
  function key(event) {
    const { key: name, shiftKey } = /** @type {KeyboardEvent} */ (event);
    if (name === "ArrowUp" || name === "ArrowDown") {
      const next = Math.max(0, Math.min(history.length, place + (name === "ArrowUp" ? -1 : 1)));
      if (place === history.length) draft = input.value;
      if (next !== place) input.value = next === history.length ? draft : history[next];
      place = next;
      offer();
    } else if (name === "Tab" && !shiftKey && offered.length && input.value.trim() && !complete()) {
      return; // nothing to complete: move to the next control
    } else if (name === "Escape") {
      hide();
      return;
    } else if (name !== "Tab" || shiftKey || !offered.length || !input.value.trim()) {
      return;
    }
    event.preventDefault();
  }

  function complete() {
    const next = offered[(chosen + 1) % offered.length];
    const text = insertion(next);
    if (input.value === text && offered.length === 1) return false;
    chosen = (chosen + 1) % offered.length;
    input.value = text;
    mark();
    return true;
  }

  function offer() {
    chosen = -1;
    offered = matches(sheet.commands ?? [], input.value).slice(0, SHOWN);
    help.replaceChildren(
      ...offered.map((one, index) => {
        const row = h("li", { role: "option", id: `${helpId}-${index}`, "aria-selected": "false" },
          h("code", {}, one.syntax || one.form), h("span", { class: "offer-name" }, one.name),
          h("span", { class: "offer-says" }, one.says));
        row.addEventListener("mousedown", (event) => {
          event.preventDefault(); // the input keeps the focus
          input.value = insertion(one);
          offer();
        });
        return row;
      }),
    );
    const open = offered.length > 0 && input.value.trim() !== "" && document.activeElement === input;
    help.hidden = !open;
    input.setAttribute("aria-expanded", String(open));
    mark();
  }

  function mark() {
    [...help.children].forEach((row, index) => row.setAttribute("aria-selected", String(index === chosen)));
    if (chosen >= 0) input.setAttribute("aria-activedescendant", `${helpId}-${chosen}`);
    else input.removeAttribute("aria-activedescendant");
  }

  function hide() {
    help.hidden = true;
    input.setAttribute("aria-expanded", "false");
  }

  return {
    close() {
      root.replaceChildren();
    },
  };
}

/**
 * Return the placeholder of an empty line.
 * @param {Record<string, any>} sheet
 * @returns {string}
 */
function example(sheet) {
  const one = sheet.commands?.find((/** @type {Command} */ each) => each.syntax.includes(" ")) ?? sheet.commands?.[0];
  return one ? `Command, such as ${one.syntax || one.form}` : "Command";
}

/**
 * Return the text to insert for a command: the command itself, and a space if arguments follow.
 * @param {Command} one
 * @returns {string}
 */
function insertion(one) {
  const syntax = one.syntax || one.form;
  const word = syntax.match(/^\S+?(?=[\s[<(]|$)/)?.[0] ?? one.form;
  return syntax.length > word.length ? `${word} ` : word;
}

/**
 * Return the commands that match a line: first by their letters, then by their names.
 * @param {Command[]} commands
 * @param {string} line
 * @returns {Command[]}
 */
export function matches(commands, line) {
  const word = line.trim().split(/\s/)[0] ?? "";
  if (!word) return [];
  const lower = word.toLowerCase();
  /** @param {Command} one */
  const rank = (one) => {
    const form = insertion(one).trim();
    if (form === word) return 0;
    if (form.startsWith(word)) return 1;
    if (word.startsWith(form) && /^[\d+-]/.test(word.slice(form.length))) return 2; // R100
    if (form.toLowerCase().startsWith(lower) || one.name.toLowerCase().startsWith(lower)) return 3;
    return word.length > 2 && one.name.toLowerCase().includes(lower) ? 4 : 9;
  };
  return commands.map((one) => ({ one, rank: rank(one) })).filter((found) => found.rank < 9)
    .sort((a, b) => a.rank - b.rank).map((found) => found.one);
}
