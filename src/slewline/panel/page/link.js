/**
 * The link to the control port: requests, events and the state of everything, over one websocket.
 *
 * The page has no other connection to the server. docs/reference/control.md lists the requests.
 */

/** @typedef {Record<string, any>} Data */
/** @typedef {(event: any) => void} Callback */
/** @typedef {{resolve: (reply: any) => void, reject: (error: Error) => void}} Waiting */

const EVERY = "33 ms"; // between two views: 30 pictures a second
const FIRST_WAIT_MS = 250; // before the first attempt to connect again
const LONGEST_WAIT_MS = 5000;
const WRONG_TOKEN = 4403; // close code of the panel; another attempt would be useless
const LOST = "The connection to the panel was lost.";

/**
 * Return whether a value has members of its own.
 * @param {unknown} value
 * @returns {value is Data}
 */
function isObject(value) {
  return typeof value === "object" && value !== null && !Array.isArray(value);
}

/**
 * Merge a change into a state, recursively; a list of objects is merged item by item, any other value is replaced.
 * @param {Data} state
 * @param {Data} change
 * @returns {Data} the state
 */
export function merge(state, change) {
  for (const [key, value] of Object.entries(change)) {
    const old = state[key];
    if (isObject(value) && isObject(old)) {
      merge(old, value);
    } else if (Array.isArray(value) && Array.isArray(old) && value.length === old.length && value.every(isObject)) {
      value.forEach((one, index) => {
        if (isObject(old[index])) merge(old[index], one);
        else old[index] = one;
      });
    } else {
      state[key] = value;
    }
  }
  return state;
}

/** Error of a request without a reply, because the connection was lost. */
class Lost extends Error {}

/**
 * Report the error of a request; the loss of the connection is shown elsewhere.
 * @param {unknown} error
 */
export function complain(error) {
  if (!(error instanceof Lost)) console.error(error);
}

export class Link {
  /**
   * @param {string} url of the websocket
   * @param {string | null} token token in the address of the page; without it only reading is allowed
   */
  constructor(url, token) {
    this.url = url;
    this.token = token;
    /** The state of everything: pace, chips, parts, findings, entries. @type {Data} */
    this.view = {};
    /** Virtual time, in picoseconds. */
    this.timePs = 0;
    /** Whether requests that move or write are allowed. */
    this.writes = false;
    /** Whether the server is connected. */
    this.connected = false;
    /** @type {Map<string, Set<Callback>>} */
    this.callbacks = new Map();
    /** @type {Map<number, Waiting>} */
    this.waiting = new Map();
    /** @type {WebSocket | null} */
    this.socket = null;
    this.number = 0;
    this.waitMs = FIRST_WAIT_MS;
    this.closed = false;
    this.watching = false;
    /** @type {ReturnType<typeof setTimeout> | undefined} */
    this.timer = undefined;
    document.addEventListener("visibilitychange", () => this.watch());
  }

  /** Connect, and reconnect whenever the connection is lost. */
  open() {
    const socket = new WebSocket(this.url);
    this.socket = socket;
    socket.addEventListener("open", () => socket.send(JSON.stringify({ token: this.token })));
    socket.addEventListener("message", (message) => this.receive(String(message.data)));
    socket.addEventListener("close", (event) => this.lost(socket, event.reason, event.code === WRONG_TOKEN));
  }

  /** End the connection. */
  close() {
    this.closed = true;
    clearTimeout(this.timer);
    this.socket?.close();
  }

  /**
   * Send a request; the promise resolves to the reply, or is rejected with the server's error.
   * @param {Data} object such as {do: "pause"}
   * @returns {Promise<any>}
   */
  request(object) {
    const socket = this.socket;
    if (!socket || socket.readyState !== WebSocket.OPEN) return Promise.reject(new Lost(LOST));
    const id = ++this.number;
    return new Promise((resolve, reject) => {
      const done = (/** @type {any} */ reply) => { this.emit("done", object); resolve(reply); };
      this.waiting.set(id, { resolve: done, reject });
      socket.send(JSON.stringify({ ...object, id }));
    });
  }

  /**
   * Call a function at every event of a name: "view", "said", "stopped", "branch" of the server; or, of the link itself,
   * connected, lost (with the reason), done (with the completed request).
   * @param {string} name
   * @param {Callback} callback
   * @returns {() => void} removes the listener
   */
  on(name, callback) {
    let all = this.callbacks.get(name);
    if (!all) this.callbacks.set(name, (all = new Set()));
    all.add(callback);
    return () => all.delete(callback);
  }

  /**
   * @param {string} name
   * @param {Data} event
   */
  emit(name, event) {
    for (const callback of [...(this.callbacks.get(name) ?? [])]) {
      try {
        callback(event);
      } catch (error) {
        console.error(error); // an error in one view must not stop the others
      }
    }
  }

  /**
   * Process a message: an event, or the reply to a request.
   * @param {string} text
   */
  receive(text) {
    const message = JSON.parse(text);
    if (typeof message.time_ps === "number") this.timePs = message.time_ps;
    if (message.event === "panel") {
      this.welcome(message);
    } else if (message.event !== undefined) {
      if (message.event === "view") merge(this.view, message.view ?? {});
      this.emit(message.event, message);
    } else {
      const waiting = this.waiting.get(message.id);
      this.waiting.delete(message.id);
      if (message.error !== undefined) waiting?.reject(new Error(message.error));
      else waiting?.resolve(message);
    }
  }

  /**
   * Process the first message of the panel: the server is connected.
   * @param {Data} message
   */
  welcome(message) {
    this.writes = message.writes === true;
    this.waitMs = FIRST_WAIT_MS;
    this.watching = false;
    this.connected = true;
    this.view = {};
    this.emit("connected", message);
    this.watch();
  }

  /** Subscribe to changes of the state while the page is visible, and unsubscribe while it is hidden. */
  watch() {
    const wanted = !document.hidden;
    if (!this.connected || wanted === this.watching) return;
    this.watching = wanted;
    this.request({ do: "subscribe", every: wanted ? EVERY : 0 }).then(
      (reply) => {
        if (!reply.view || !wanted) return;
        this.view = reply.view;
        this.emit("view", { event: "view", time_ps: this.timePs, view: reply.view });
      },
      complain,
    );
  }

  /**
   * @param {WebSocket} socket
   * @param {string} reason
   * @param {boolean} forGood
   */
  lost(socket, reason, forGood) {
    if (socket !== this.socket) return;
    this.connected = false;
    for (const waiting of this.waiting.values()) waiting.reject(new Lost(reason || LOST));
    this.waiting.clear();
    this.emit("lost", { event: "lost", reason: reason || LOST });
    if (this.closed || forGood) return;
    this.timer = setTimeout(() => this.open(), this.waitMs);
    this.waitMs = Math.min(2 * this.waitMs, LONGEST_WAIT_MS);
  }
}
