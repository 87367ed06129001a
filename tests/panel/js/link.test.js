import assert from "node:assert/strict";
import { test } from "node:test";

import { Link } from "../../../src/slewline/panel/page/link.js";

class Socket extends EventTarget {
  static OPEN = 1;
  readyState = 1;
  sent = [];

  send(text) {
    this.sent.push(JSON.parse(text));
  }

  close() {}

  /** The panel sends a message. */
  hears(object) {
    this.dispatchEvent(Object.assign(new Event("message"), { data: JSON.stringify(object) }));
  }

  /** The connection ends. */
  ends(reason) {
    this.dispatchEvent(Object.assign(new Event("close"), { reason, code: 4502 }));
  }
}

/** Return a link that is connected, and its socket. */
function connected() {
  globalThis.document = new EventTarget();
  globalThis.WebSocket = Socket;
  const link = new Link("ws://panel", "token");
  link.open();
  link.socket.hears({ event: "panel", writes: true });
  return [link, link.socket];
}

test("a request that is pending when the connection is lost is not an error of the page", async (context) => {
  const told = context.mock.method(console, "error", () => {});
  const [link, socket] = connected();
  assert.equal(socket.sent.at(-1).do, "subscribe");
  const request = link.request({ do: "status" });
  socket.ends("The server has ended the connection.");
  await assert.rejects(request, /The server has ended the connection/);
  link.close();
  assert.equal(told.mock.callCount(), 0);
});

test("a subscription that is refused is one", async (context) => {
  const told = context.mock.method(console, "error", () => {});
  const [link, socket] = connected();
  socket.hears({ id: socket.sent.at(-1).id, error: "subscribe: no" });
  await null;
  link.close();
  assert.equal(told.mock.callCount(), 1);
});
