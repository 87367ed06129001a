/**
 * The dialogue of hosts and chips, in both directions, with the findings next to the bytes that caused them.
 */

import { button, choices, field, h, select } from "./dom.js";
import { clock } from "./format.js";
import { complain } from "./link.js";

/** @typedef {import("./link.js").Link} Link */
/** @typedef {{number: number, time_ps: number, who: string, kind: string, text: string, code?: string}} Entry */

const MOST = 2000; // rows
const NEAR_PX = 30; // from the end: the list scrolls with new rows
const CALM_MS = 1000; // between two findings that are read aloud
/** @type {Record<string, [string, string]>} */
const KINDS = {
  sent: ["→", "Sent"], got: ["←", "Got"], command: ["▸", "Commands"], event: ["·", "Events"],
  finding: ["!", "Findings"],
};

/**
 * Show the dialogue.
 * @param {Link} link
 * @param {HTMLElement} root
 * @returns {{update: (view: any) => void, close: () => void}}
 */
export function dialogue(link, root) {
  /** @type {Map<number, HTMLElement>} */
  let rows = new Map();
  /** @type {Entry[]} */
  let coming = [];
  let newest = -1;
  let generation = 0; // of the dialogue: each branch has its own
  let aloudAt = 0;
  let follows = true;

  const filters = Object.entries(KINDS).map(([kind, [, name]]) => {
    const one = h("button", { type: "button", class: "chip-button", "aria-pressed": "true", "data-kind": kind }, name);
    one.addEventListener("click", () => {
      const shows = one.getAttribute("aria-pressed") !== "true";
      one.setAttribute("aria-pressed", String(shows));
      list.classList.toggle(`no-${kind}`, !shows);
      toEnd();
    });
    return one;
  });
  const who = select("Chip or part", { "": "all" }, { change: filter });
  const words = field("Find in the conversation", { type: "search", placeholder: "Find", size: 10, input: filter });
  const list = h("ol", { class: "said", tabindex: 0, "aria-label": "Conversation", scroll: scrolled });
  const latest = button("Latest ↓", () => { follows = true; toEnd(); }, { class: "latest", "data-writes": null, hidden: true });
  const aloud = h("div", { class: "unseen", role: "status", "aria-live": "polite" });
  root.append(
    h("div", { class: "row filters", role: "group", "aria-label": "Kinds of entries" }, ...filters),
    h("div", { class: "row filters" }, who, words),
    h("div", { class: "said-frame" }, list, latest),
    aloud,
  );

  function scrolled() {
    follows = list.scrollHeight - list.scrollTop - list.clientHeight < NEAR_PX;
    latest.hidden = follows;
  }

  function toEnd() {
    if (follows) list.scrollTop = list.scrollHeight;
    latest.hidden = follows;
  }

  /** @param {HTMLElement} row */
  function isWanted(row) {
    const word = words.value.toLowerCase();
    return (!who.value || row.dataset.who === who.value) &&
      (!word || (row.textContent ?? "").toLowerCase().includes(word));
  }

  function filter() {
    for (const row of rows.values()) row.hidden = !isWanted(row);
    toEnd();
  }

  /** @param {Entry} entry */
  function element(entry) {
    const [sign, name] = KINDS[entry.kind] ?? ["·", entry.kind];
    const row = h(
      "li",
      { class: `entry ${entry.kind}`, "data-who": entry.who },
      h("time", {}, clock(entry.time_ps)),
      h("span", { class: "who" }, entry.who),
      h("span", { class: "sign", title: name, "aria-label": name, role: "img" }, sign),
      h("span", { class: "what" }, entry.code && h("b", { class: "code" }, entry.code), ...visible(entry.text)),
    );
    row.hidden = !isWanted(row);
    return row;
  }

  /** @param {Entry} entry */
  function take(entry) {
    const old = rows.get(entry.number);
    const row = element(entry);
    rows.set(entry.number, row);
    if (old) old.replaceWith(row);
    else if (entry.number > newest) list.append(row);
    newest = Math.max(newest, entry.number);
    if (entry.kind === "finding" && !old) announce(entry);
  }

  /** @param {Entry} entry */
  function announce(entry) {
    const now = performance.now();
    if (now - aloudAt < CALM_MS) return;
    aloudAt = now;
    aloud.textContent = `Finding of ${entry.who}: ${entry.text}`;
  }

  function flush() {
    if (!coming.length) return;
    const entries = coming.slice(-MOST);
    coming = [];
    for (const entry of entries) if (entry.number > newest - MOST) take(entry);
    for (const [number, row] of rows) {
      if (rows.size <= MOST) break;
      rows.delete(number);
      row.remove();
    }
    toEnd();
  }

  async function reload() {
    const mine = ++generation;
    try {
      const start = Math.max(0, (link.view.entries ?? 0) - MOST);
      const reply = await link.request({ do: "said", start });
      if (mine !== generation) return;
      rows = new Map();
      newest = -1;
      coming = [...reply.entries, ...coming.filter((entry) => entry.number > (reply.entries.at(-1)?.number ?? -1))];
      list.replaceChildren();
      aloudAt = performance.now(); // old findings are not read aloud
      flush();
    } catch (error) {
      complain(error);
    }
  }

  const gone = [
    link.on("said", (event) => {
      coming.push(...event.entries);
      if (coming.length > 2 * MOST) coming = coming.slice(-MOST); // a hidden page draws nothing for hours
    }),
    link.on("branch", () => { coming = []; reload(); }),
  ];
  let names = "";
  reload();
  return {
    update(view) {
      const all = [...Object.keys(view.chips ?? {}), ...Object.keys(view.parts ?? {})];
      if (all.join() !== names) {
        names = all.join();
        choices(who, { "": "all", ...Object.fromEntries(all.map((name) => [name, name])) });
      }
      flush();
    },
    close() {
      generation++;
      gone.forEach((end) => end());
      root.replaceChildren();
    },
  };
}

/**
 * Return a text in pieces, with the codes of unprintable bytes separated.
 * @param {string} text
 * @returns {(Node | string)[]}
 */
function visible(text) {
  return text.split(/(\\x[0-9a-fA-F]{2}|\\[rnt\\])/).map((piece, index) =>
    index % 2 ? h("span", { class: "byte" }, piece) : piece);
}
