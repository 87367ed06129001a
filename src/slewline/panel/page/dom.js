/**
 * Elements created without markup: data from outside is inserted only as text.
 */

/** @typedef {Node | string | null | undefined | false} Child */

let writes = false; // whether this page may move and write

/**
 * Enable or disable all elements with data-writes, which move or write, now and later.
 * @param {boolean} allowed
 */
export function allowWrites(allowed) {
  writes = allowed;
  for (const element of document.querySelectorAll("[data-writes]")) {
    /** @type {HTMLButtonElement} */ (element).disabled = !allowed;
  }
}

/**
 * Return a new element.
 * @template {keyof HTMLElementTagNameMap} T
 * @param {T} tag
 * @param {Record<string, unknown>} [attributes] a function becomes a listener for its event; false and null omit it
 * @param {...Child} children
 * @returns {HTMLElementTagNameMap[T]}
 */
export function h(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (typeof value === "function") element.addEventListener(name, /** @type {EventListener} */ (value));
    else if (value === true) element.setAttribute(name, "");
    else if (value !== false && value !== null && value !== undefined) element.setAttribute(name, String(value));
  }
  if (attributes["data-writes"] === true) /** @type {any} */ (element).disabled = !writes;
  put(element, ...children);
  return element;
}

/**
 * Append children to an element.
 * @param {Element} element
 * @param {...Child} children
 */
export function put(element, ...children) {
  for (const child of children) if (child) element.append(child);
}

/**
 * Set the text of an element, if it has changed.
 * @param {Element} element
 * @param {string} text
 * @returns {boolean} whether it has changed
 */
export function say(element, text) {
  const only = element.childNodes.length === 1 ? element.firstChild : null;
  if (only instanceof Text) { // changing a text node takes less layout time than replacing it
    if (only.data === text) return false;
    only.data = text;
    return true;
  }
  if (element.textContent === text) return false;
  element.textContent = text;
  return true;
}

/**
 * Return a button for a request that moves or writes; on a read-only page it is disabled.
 * @param {string} text
 * @param {(event: Event) => void} click
 * @param {Record<string, unknown>} [attributes]
 * @returns {HTMLButtonElement}
 */
export function button(text, click, attributes = {}) {
  return h("button", { type: "button", "data-writes": true, click, ...attributes }, text);
}

/**
 * Return a list to choose from.
 * @param {string} label its accessible name
 * @param {Record<string, string>} options text by value
 * @param {Record<string, unknown>} [attributes]
 * @returns {HTMLSelectElement}
 */
export function select(label, options, attributes = {}) {
  const element = h("select", { "aria-label": label, ...attributes });
  choices(element, options);
  return element;
}

/**
 * Replace the options of a list; the selection is kept if it still exists.
 * @param {HTMLSelectElement} element
 * @param {Record<string, string>} options text by value
 */
export function choices(element, options) {
  const chosen = element.value;
  element.replaceChildren(...Object.entries(options).map(([value, text]) => h("option", { value }, text)));
  if (chosen in options) element.value = chosen;
}

/**
 * Return a text input of one line.
 * @param {string} label its accessible name
 * @param {Record<string, unknown>} [attributes]
 * @returns {HTMLInputElement}
 */
export function field(label, attributes = {}) {
  return h("input", {
    type: "text", "aria-label": label, autocomplete: "off", autocapitalize: "off", spellcheck: "false", ...attributes,
  });
}

/**
 * Return an icon: a path in a square of 16.
 * @param {string} path
 * @returns {SVGSVGElement}
 */
export function icon(path) {
  const space = "http://www.w3.org/2000/svg";
  const svg = document.createElementNS(space, "svg");
  svg.setAttribute("viewBox", "0 0 16 16");
  svg.setAttribute("aria-hidden", "true");
  svg.classList.add("icon");
  const shape = document.createElementNS(space, "path");
  shape.setAttribute("d", path);
  svg.append(shape);
  return svg;
}

/**
 * Return a function that calls another one after it has not been called for a while (debounce).
 * @param {() => void} call
 * @param {number} ms
 * @returns {() => void}
 */
export function calmly(call, ms) {
  /** @type {ReturnType<typeof setTimeout> | undefined} */
  let timer;
  return () => {
    clearTimeout(timer);
    timer = setTimeout(call, ms);
  };
}
