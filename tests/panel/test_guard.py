"""The application of the panel without its server: which requests it refuses, and what binds the browser."""

from __future__ import annotations

import asyncio

from starlette.datastructures import Headers

from slewline.panel.guard import Guard
from slewline.panel.relay import Access
from slewline.panel.web_server import application

from .test_safety import HOSTILE, ORIGINS, OURS

PORT = 8765
USUAL = f"127.0.0.1:{PORT}"


def answers(app, kind="http", path="/", **headers):
    """Return the messages with which an application answers a request, or the opening of a websocket."""
    sent = []

    coming = iter([{"type": {"http": "http.request", "websocket": "websocket.connect"}[kind]}])

    async def receive():
        return next(coming, {"type": f"{kind}.disconnect"})

    async def send(message):
        sent.append(message)

    pairs = [(name.encode(), value.encode()) for name, value in ({"host": USUAL} | headers).items()]
    scope = {"type": kind, "method": "GET", "path": path, "headers": pairs, "query_string": b"", "root_path": ""}
    asyncio.run(app(scope, receive, send))
    return sent


def get(path="/", remote=False, **headers):
    """Return the status, headers and body of a page."""
    access = Access("127.0.0.1", 1, "t", None)
    begin, *rest = answers(application(access, PORT, "lab.example", remote), path=path, **headers)
    return begin["status"], Headers(raw=begin["headers"]), b"".join(part["body"] for part in rest)


def test_another_host_is_refused(subtests):
    for host in HOSTILE:
        for path in ("/", "/panel.js", "/link"):
            with subtests.test(host=host, path=path):
                status, headers, body = get(path, host=host.format(port=PORT))
                assert (status, headers["connection"]) == (403, "close")
                assert b"script" not in body and headers["x-frame-options"] == "DENY"


def test_our_own_names_are_answered(subtests):
    for host in (*OURS, "lab.example:{port}"):
        with subtests.test(host):
            assert get(host=host.format(port=PORT))[0] == 200
    for port in (PORT, 9999):
        assert get(host=f"10.0.0.1:{port}", remote=True)[0] == 200  # an address is bound to nothing else
        assert get(host=f"10.0.0.1:{port}")[0] == 403
    assert get(host="lab.example:9999")[0] == 403  # a name is, on another port
    assert get(host=f"evil.example:{PORT}", remote=True)[0] == 403


def test_every_answer_binds_the_browser(subtests):
    for path, found in (("/", 200), ("/panel.js", 200), ("/style.css", 200), ("/nothing", 404), ("/../app.py", 404)):
        with subtests.test(path):
            status, headers, body = get(path)
            assert status == found and b"import uvicorn" not in body
            policy = headers["content-security-policy"]
            assert "default-src 'none'" in policy and "frame-ancestors 'none'" in policy
            assert "unsafe" not in policy and "*" not in policy
            assert headers["x-content-type-options"] == "nosniff" and headers["cache-control"] == "no-store"
            assert "access-control-allow-origin" not in headers


def test_only_our_own_page_opens_a_websocket(subtests):
    async def app(scope, receive, send):
        await send({"type": "websocket.accept"})

    guard = Guard(app, PORT, "127.0.0.1")
    for origin in (None, *ORIGINS):
        with subtests.test(origin=origin):
            headers = {} if origin is None else {"origin": origin.format(port=PORT)}
            assert answers(guard, "websocket", "/link", **headers) == [{"type": "websocket.close"}]
    assert answers(guard, "websocket", "/link", origin=f"http://{USUAL}") == [{"type": "websocket.accept"}]
