/**
 * The page: connects to the server, arranges its chips, and draws changes.
 */

import { Breakpoints, breakpointsView } from "./breakpoints.js";
import { chipCard } from "./chip.js";
import { dialogue } from "./dialogue.js";
import { allowWrites, h, say } from "./dom.js";
import { editor } from "./editor.js";
import { Link } from "./link.js";
import { timebar } from "./timebar.js";

/**
 * A display. One that `moves` is drawn with every view, others only as often as a reader can follow; `legible`
 * marks those moments for the first kind.
 * @typedef {{update: (view: any, timePs: number, legible: boolean) => void, close?: () => void, moves?: boolean}} View
 */

const NOTICE_MS = 8000;
const TEXT_MS = 100; // between two updates of text
const EARLY_MS = 10; // by which an update may be early, because with the next view it would be too late
const THEME = "slewline theme";

/**
 * Return the element of the page with this name.
 * @param {string} id
 * @returns {HTMLElement}
 */
function part(id) {
  return /** @type {HTMLElement} */ (document.getElementById(id));
}

const token = new URLSearchParams(location.hash.slice(1)).get("token");
const link = new Link(`ws://${location.host}/link`, token);
/** The views on display. @type {View[]} */
let views = [];
/** @type {Map<string, any>} */
const sheets = new Map();
let generation = 0; // of the layout: incremented with each connection
let asked = false; // a redraw is due
let textMs = -Infinity; // time of the last complete drawing
/** @type {ReturnType<typeof setTimeout> | undefined} */
let textTimer;
let machineSeen = true;

/** @type {ReturnType<typeof setTimeout> | undefined} */
let noticeTimer;
const ACTS = new Set(["send", "go", "pause", "step", "until", "breakpoints", "drive", "release", "act", "power"]);

/**
 * Show an error for a while.
 * @param {Error} error
 */
function fail(error) {
  const notice = part("notice");
  notice.textContent = error.message;
  notice.hidden = false;
  clearTimeout(noticeTimer);
  noticeTimer = setTimeout(() => { notice.hidden = true; }, NOTICE_MS);
}

link.on("done", ({ do: what }) => { if (ACTS.has(what)) part("notice").hidden = true; }); // an older error no longer applies

const breakpoints = new Breakpoints(link, fail);

/** Return the time until text is due again, in milliseconds. */
function textWaitMs() {
  return textMs + TEXT_MS - EARLY_MS - performance.now();
}

/** Draw with the next frame of the screen; a hidden page has none. */
function redraw() {
  if (asked) return;
  const waitMs = textWaitMs();
  clearTimeout(textTimer);
  if (waitMs > 0) textTimer = setTimeout(redraw, waitMs + EARLY_MS); // if no other view arrives until then
  if (waitMs > 0 && !machineSeen) {
    update(false); // a frame takes time even if it draws nothing
    return;
  }
  asked = true;
  requestAnimationFrame(() => {
    asked = false;
    update(textWaitMs() <= 0); // decided here, not above: before a late frame, the timer fires in vain
  });
}

/** @param {boolean} legible */
function update(legible) {
  if (legible) {
    textMs = performance.now();
    clearTimeout(textTimer);
  }
  for (const view of views) {
    if (!legible && !view.moves) continue;
    try {
      view.update(link.view, link.timePs, legible);
    } catch (error) {
      console.error(error); // an error in one view must not stop the others
    }
  }
  if (!legible) return;
  say(part("findings"), String(link.view.findings ?? 0));
  part("findings-badge").classList.toggle("some", (link.view.findings ?? 0) > 0);
}

/** Update which controls are enabled. */
function applyAccess() {
  document.body.classList.toggle("read-only", link.connected && !link.writes);
  allowWrites(link.connected && link.writes);
}

/** Arrange the page for the chips and parts of the server. */
async function layOut() {
  const mine = ++generation;
  const names = Object.keys(link.view.chips ?? {});
  /** @type {any[]} */
  let replies;
  try {
    replies = await Promise.all(names.map((chip) => link.request({ do: "describe", chip })));
  } catch (error) {
    fail(/** @type {Error} */ (error));
    return;
  }
  if (mine !== generation) return;
  for (const view of views) view.close?.();
  views = [];
  sheets.clear();
  names.forEach((name, index) => sheets.set(name, replies[index].sheet));
  for (const id of ["timebar", "chips", "conversation", "editor", "machine", "scope"]) part(id).replaceChildren();
  document.body.classList.toggle("one-chip", names.length === 1);

  views.push(timebar(link, part("timebar"), fail));
  views.push(breakpointsView(breakpoints, part("breakpoints")));
  for (const name of names) {
    const root = h("div", { class: "card-frame" });
    part("chips").append(root);
    views.push(chipCard(link, sheets.get(name), name, root, breakpoints, fail));
  }
  views.push(dialogue(link, part("conversation")));
  views.push(editor(link, sheets, part("editor"), fail));
  document.title = `${names.join(", ")} · slewline`;
  graphic("machine.js", "machine", mine);
  graphic("scope.js", "scope", mine);
  breakpoints.renew();
  textMs = -Infinity;
  redraw();
}

/**
 * Show a view that draws, if its module exists.
 * @param {string} file
 * @param {"machine" | "scope"} name name of its function and of its section
 * @param {number} mine
 */
async function graphic(file, name, mine) {
  const place = part(name);
  const frame = /** @type {HTMLElement} */ (place.closest("section"));
  try {
    const module = await import(`./${file}`);
    if (mine !== generation) return;
    frame.hidden = false;
    views.push(module[name](link, place));
    frame.hidden = !place.childElementCount;
    textMs = -Infinity;
    redraw();
  } catch (error) {
    frame.hidden = true;
    console.info(error);
  }
}

/** @param {string} text */
function status(text) {
  say(part("connection-text"), text);
  part("connection").className = link.connected ? "connection on" : "connection off";
}

/** Switch between dark and light; by default the system's. */
function switchTheme() {
  const dark = matchMedia("(prefers-color-scheme: dark)").matches;
  const now = document.documentElement.dataset.theme ?? (dark ? "dark" : "light");
  setTheme(now === "dark" ? "light" : "dark");
}

/** @param {string} theme */
function setTheme(theme) {
  document.documentElement.dataset.theme = theme;
  try {
    localStorage.setItem(THEME, theme);
  } catch { /* the browser has no storage */ }
}

/** Show one of the tabs next to the chips. */
function setUpTabs() {
  const tabs = [...document.querySelectorAll("[role=tab]")];
  /** @param {Element} chosen */
  const show = (chosen) => {
    for (const tab of tabs) {
      const isChosen = tab === chosen;
      tab.setAttribute("aria-selected", String(isChosen));
      /** @type {HTMLElement} */ (tab).tabIndex = isChosen ? 0 : -1;
      part(tab.getAttribute("aria-controls") ?? "").hidden = !isChosen;
    }
  };
  tabs.forEach((tab, index) => {
    tab.addEventListener("click", () => show(tab));
    tab.addEventListener("keydown", (event) => {
      const by = { ArrowRight: 1, ArrowLeft: -1 }[/** @type {KeyboardEvent} */ (event).key];
      if (!by) return;
      const next = tabs[(index + by + tabs.length) % tabs.length];
      show(next);
      /** @type {HTMLElement} */ (next).focus();
    });
  });
}

/** On a small screen: a bar that links to every section. */
function setUpJumps() {
  for (const one of document.querySelectorAll("#jump button")) {
    const { to, tab } = /** @type {HTMLElement} */ (one).dataset;
    one.addEventListener("click", () => {
      if (tab) part(tab).click();
      part(to ?? "").scrollIntoView({ block: "start" });
    });
  }
}

try {
  const kept = localStorage.getItem(THEME);
  if (kept === "dark" || kept === "light") setTheme(kept);
} catch { /* the browser has no storage */ }
new ResizeObserver(([entry]) => {
  document.documentElement.style.setProperty("--top", `${Math.ceil(entry.borderBoxSize[0].blockSize)}px`);
}).observe(part("top"));
new IntersectionObserver((entries) => {
  machineSeen = entries[entries.length - 1].isIntersecting;
}).observe(part("machine"));
part("theme").addEventListener("click", switchTheme);
setUpTabs();
setUpJumps();

let known = "";
link.on("connected", () => {
  known = "";
  applyAccess();
  status(link.writes ? "connected" : "connected, read-only");
});
link.on("lost", (event) => {
  status(event.reason);
  applyAccess();
});
link.on("view", () => {
  const names = Object.keys(link.view.chips ?? {}).join();
  if (names !== known) {
    known = names;
    layOut();
  }
  redraw();
});
addEventListener("hashchange", () => location.reload()); // another token
status("connecting…");
link.open();
