/**
 * The controls of time: pause and go, rate, single steps, run to a target, going back to the past, branches.
 */

import { button, choices, field, h, icon, say, select } from "./dom.js";
import { asTime, clock, grouped, picoseconds, readable, times, wholeNumber, writtenTime } from "./format.js";

/** @typedef {import("./link.js").Link} Link */

const RATES = [0.01, 0.1, 1, 10, 100, 1000];
const NOTCHES = 10_000; // of the slider
const PAUSE = "M4 3h3v10H4zM9 3h3v10H9z";
const GO = "M4 2.5v11l9-5.5z";
const EARLY_PS = 1e11; // before this time, a paused program counts as not yet begun
const STEP_TIMEOUT = "60 s";
/** @type {Record<string, string>} */
const PLACES = { time: "instant", position: "position", address: "line" };
/** @type {Record<string, string>} */
const HINTS = { time: "1.5 s", position: "400", address: "7" };

/**
 * Show the controls of time.
 * @param {Link} link
 * @param {HTMLElement} root
 * @param {(error: Error) => void} fail
 * @returns {{update: (view: any, timePs: number) => void, close: () => void}}
 */
export function timebar(link, root, fail) {
  let horizonPs = 0; // latest time of this branch
  let rate = 1;
  let paused = false;
  let scrubbing = false;
  let waits = 0; // requests that wait for a condition
  /** @type {number | null} */
  let wantedPs = null; // the instant selected by the slider, while a request is in progress
  let sending = false;
  let base = 0; // the branch of the slider: the one from which it has gone back, until time passes again
  /** The instant and the branch to which the slider has led. @type {{branch: number, ps: number} | null} */
  let visit = null;

  const now = h("output", { class: "clock", "aria-label": "Virtual time in seconds" });
  const go = h("button", { type: "button", "data-writes": true, class: "go", click: toggle, title: "F8" });
  const start = button("Run the program", toggle, { class: "start", hidden: true });
  start.prepend(icon(GO));
  const rates = RATES.map((one) =>
    button(times(one), () => setRate(one), { "aria-pressed": "false", "aria-label": `${one} times real time` }));
  const chip = select("Chip to step", {});
  const steps = [
    button("Instruction", () => step({ by: "instruction" }), { title: "One instruction of the program (F10)" }),
    button("Step", () => step({ by: "step" }), { title: "One step of the motor (F9)" }),
    button("Command", () => step({ by: "command" }), { title: "To the next command" }),
  ];
  const pins = h("datalist", { id: "all-pins" });
  const pin = field("Pin to wait for", { list: "all-pins", size: 10, placeholder: "pin" });
  const edge = select("Edge", { any: "any edge", rises: "rises", falls: "falls" });
  const place = select("Run to", PLACES, { change: () => { value.placeholder = HINTS[place.value]; } });
  const value = field("Target of the run", { size: 7, placeholder: HINTS.time });
  const slider = h("input", {
    type: "range", min: 0, max: NOTCHES, value: NOTCHES, "data-writes": true, "aria-label": "Past",
    input: scrub, change: scrub,
  });
  const began = h("span", { class: "quiet" }, "0");
  const ended = h("span", { class: "quiet" });
  const branches = select("Branch", {}, { "data-writes": true, change: changeBranch, hidden: true });
  const state = h("span", { class: "stopped", role: "status", "aria-live": "polite" });
  const more = h("div", { class: "bar-steps" },
    h("div", { class: "group", role: "group", "aria-label": "Single step" },
      h("span", { class: "caption" }, "Step"), chip, ...steps),
    h("form", { class: "group", submit: nextEdge },
      h("span", { class: "caption" }, "Next edge"), pin, pins, edge, h("button", { "data-writes": true, "aria-label": "To the next edge" }, "Go")),
    h("form", { class: "group", submit: runTo },
      h("span", { class: "caption" }, "Run to"), place, value, h("button", { "data-writes": true, "aria-label": "Run there" }, "Go")),
    h("div", { class: "group", id: "breakpoints" }), state);
  const opens = h("button", {
    type: "button", class: "opens-steps", "aria-expanded": "false",
    click: () => opens.setAttribute("aria-expanded", String(more.classList.toggle("open"))),
  }, "Steps…");

  root.append(
    h("div", { class: "bar-time" }, now, start, go,
      h("div", { class: "rates", role: "group", "aria-label": "Rate" }, ...rates), opens),
    h("div", { class: "bar-past" }, began, slider, ended, branches),
    more,
  );
  document.addEventListener("keydown", shortcut);

  /**
   * @param {Record<string, any>} request
   * @returns {Promise<any>}
   */
  async function ask(request) {
    try {
      return await link.request(request);
    } catch (error) {
      fail(/** @type {Error} */ (error));
      return null;
    }
  }

  function toggle() {
    say(state, "");
    ask(paused ? { do: "go", rate: String(rate) } : { do: "pause" });
  }

  /** @param {number} one */
  function setRate(one) {
    rate = one;
    show();
    if (!paused) ask({ do: "go", rate: String(one) });
  }

  /**
   * @param {Record<string, any>} request
   */
  async function wait(request) {
    waits++;
    say(state, "running…");
    const reply = await ask(request);
    waits--;
    if (reply === null) say(state, "");
    else if (reply.met === false) say(state, [`not within ${request.timeout}`, reply.why].filter(Boolean).join("; "));
    else if (state.textContent === "running…") say(state, "");
  }

  /** @param {Record<string, any>} what */
  function step(what) {
    wait({ do: "step", chip: chip.value, timeout: STEP_TIMEOUT, ...what });
  }

  /** @param {Event} event */
  function nextEdge(event) {
    event.preventDefault();
    const name = pin.value.trim();
    if (!name) return pin.focus();
    wait({ do: "step", pin: name.includes(".") ? name : `${chip.value}.${name}`, edge: edge.value, timeout: STEP_TIMEOUT });
  }

  /** @param {Event} event */
  async function runTo(event) {
    event.preventDefault();
    const text = value.value.trim();
    if (!text) {
      value.focus();
      return fail(new Error(`Run to: write the ${PLACES[place.value]}, such as ${HINTS[place.value]}`));
    }
    let number = NaN;
    let instantPs = NaN;
    try {
      if (place.value === "time") instantPs = picoseconds(text);
      else number = wholeNumber(text, PLACES[place.value]);
      if (place.value === "address") await checkLine(number);
    } catch (error) {
      return fail(/** @type {Error} */ (error));
    }
    if (instantPs < link.timePs) { // to an instant in the past, go as the slider does
      wantedPs = instantPs;
      scrubbing = true;
      say(state, "");
      return goBack();
    }
    if (!paused) await ask({ do: "pause" });
    wait(place.value === "time" ? { do: "until", time: writtenTime(text) } :
      { do: "until", chip: chip.value, [place.value]: number, timeout: STEP_TIMEOUT });
  }

  /**
   * Refuse an address at which no instruction of the stored program begins.
   * @param {number} address
   */
  async function checkLine(address) {
    const { rows } = await link.request({ do: "listing", chip: chip.value });
    const known = rows.map((/** @type {any} */ row) => row.address);
    if (known.includes(address)) return;
    const there = known.length ? `the first one is at ${known[0]}, the last one at ${known.at(-1)}` : `no program is stored in ${chip.value}`;
    throw new Error(`line ${address}: no instruction begins there; ${there}`);
  }

  function scrub() {
    wantedPs = (Number(slider.value) / NOTCHES) * horizonPs;
    say(now, clock(wantedPs));
    scrubbing = true;
    say(state, "");
    goBack();
  }

  async function goBack() {
    if (sending) return;
    sending = true;
    while (wantedPs !== null) { // only the last position of the slider is used; earlier ones are skipped
      const ps = wantedPs;
      wantedPs = null;
      visit = { branch: -1, ps };
      const reply = await ask({ do: "back", time: asTime(ps), branch: base });
      if (reply) visit = { branch: reply.branch, ps: reply.time_ps ?? ps };
      else visit = null;
    }
    sending = scrubbing = false;
    readBranches();
  }

  function changeBranch() {
    ask({ do: "branch", number: Number(branches.value) });
  }

  async function readBranches() {
    try {
      const reply = await link.request({ do: "branches" });
      const current = reply.branches.find((/** @type {any} */ one) => one.number === reply.current);
      if (sending) return;
      if (visit?.branch !== reply.current) {
        visit = null;
        base = reply.current;
        horizonPs = Math.max(link.timePs, current?.now_ps ?? 0);
      }
      choices(branches, Object.fromEntries(reply.branches.map((/** @type {any} */ one) =>
        [String(one.number), one.parent === null || one.parent === undefined ? `branch ${one.number}` :
          `branch ${one.number}, of ${one.parent} from ${readable(one.from_ps)}`])));
      branches.value = String(reply.current);
      branches.hidden = reply.branches.length < 2;
    } catch {
      branches.hidden = true; // the server has no past
    }
  }

  /** @param {KeyboardEvent} event */
  function shortcut(event) {
    /** @type {Record<string, () => void>} */
    const calls = { F8: toggle, F9: () => step({ by: "step" }), F10: () => step({ by: "instruction" }) };
    if (!(event.key in calls) || event.ctrlKey || event.altKey || event.metaKey || !link.writes) return;
    event.preventDefault();
    calls[event.key]();
  }

  function show() {
    const name = paused ? "Go" : "Pause";
    if (go.dataset.name !== name) {
      go.dataset.name = name;
      go.replaceChildren(icon(paused ? GO : PAUSE), name);
    }
    rates.forEach((one, index) => one.setAttribute("aria-pressed", String(RATES[index] === rate)));
  }

  const gone = [
    link.on("stopped", (event) => say(state, event.why ?? "")),
    link.on("branch", readBranches),
  ];
  readBranches();
  show();
  let names = "";
  /** @type {number | null} */
  let toldRate = null;
  /** The first displayed instant. @type {number | null} */
  let firstPs = null;
  return {
    update(view, timePs) {
      if (visit && !sending && view.pace?.branch === visit.branch && timePs > visit.ps) { // time passes in the new branch
        base = visit.branch;
        visit = null;
        horizonPs = timePs;
      }
      horizonPs = Math.max(horizonPs, timePs);
      const pace = view.pace ?? {};
      paused = pace.paused === true;
      if (typeof pace.rate === "number" && pace.rate !== toldRate) rate = toldRate = pace.rate;
      root.classList.toggle("paused", paused);
      root.classList.toggle("waits", waits > 0);
      if (pace.lockstep) go.disabled = true;
      firstPs ??= timePs;
      start.hidden = !paused || timePs !== firstPs || timePs > EARLY_PS;
      go.hidden = !start.hidden; // only one button to start
      show();
      if (!scrubbing) {
        say(now, clock(timePs));
        const notch = String(horizonPs ? Math.round((timePs / horizonPs) * NOTCHES) : NOTCHES);
        if (slider.value !== notch) slider.value = notch;
        slider.setAttribute("aria-valuetext", readable(timePs));
      }
      say(ended, `${grouped((horizonPs / 1e12).toFixed(1))} s`);
      const all = Object.keys(view.chips ?? {});
      if (all.join() === names) return;
      names = all.join();
      choices(chip, Object.fromEntries(all.map((one) => [one, one])));
      chip.hidden = all.length < 2;
      pins.replaceChildren(...all.flatMap((one) =>
        Object.keys(view.chips[one].levels ?? {}).map((own) => h("option", { value: `${one}.${own}` }))));
    },
    close() {
      document.removeEventListener("keydown", shortcut);
      gone.forEach((end) => end());
      root.replaceChildren();
    },
  };
}
