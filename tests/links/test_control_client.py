"""The client of the control port, for programs with asyncio."""

from __future__ import annotations

import asyncio
import json
from contextlib import asynccontextmanager

import pytest

import slewline
from slewline.errors import UsageError
from slewline.links.clients.control_client import ConnectionEnded, ControlClient, merged
from slewline.links.lines.pace import Lockstep
from slewline.links.server import Server


@asynccontextmanager
async def served(token=None):
    """A server in a thread, whose time stands, and a client of it."""
    bench = slewline.Bench()
    host = bench.host(bench.add("cy525", name="x"))
    host.send("N 5\rG\r")
    server = Server(bench, Lockstep(bench))
    server.pace.pause_time()
    where = server.control("127.0.0.1:0", token).where
    running = asyncio.get_running_loop().run_in_executor(None, server.run)
    client = await ControlClient.connect(where, token)
    try:
        yield client, where
    finally:
        await client.close()
        server.stop()
        await running


@asynccontextmanager
async def script(*lines):
    """A port that answers the first request, and then sends these lines, each when there is another request."""

    async def talk(reader, writer):
        for line in ({"time_ps": 0}, *lines):
            request = json.loads(await reader.readline())
            for each in line if isinstance(line, list) else [line]:
                writer.write(json.dumps({"id": request["id"] + each.pop("later", 0)} | each).encode() + b"\n")
        await reader.readline()
        writer.close()

    server = await asyncio.start_server(talk, "127.0.0.1", 0)
    client = await ControlClient.connect(f"127.0.0.1:{server.sockets[0].getsockname()[1]}")
    try:
        yield client
    finally:
        await client.close()
        server.close()


def test_requests_and_the_view():
    async def main():
        async with served() as (client, _):
            view = await client.subscribe("10 ms")
            assert view["chips"]["x"]["axes"][0]["position"] == client.view["chips"]["x"]["axes"][0]["position"]
            start = view["chips"]["x"]["axes"][0]["position"]
            events = client.events()
            waiting = asyncio.ensure_future(anext(events))
            reply = await client.request("step", chip="x", by="step")
            assert reply["met"]
            assert client.now_ps == reply["time_ps"]
            assert (await waiting)["event"] in ("view", "said")
            while client.view["chips"]["x"]["axes"][0]["position"] == start:
                await anext(events)
            assert client.view["chips"]["x"]["axes"][0]["position"] == start + 1
            await events.aclose()

    asyncio.run(main())


def test_refusals_of_the_server():
    async def main():
        async with served() as (client, _):
            with pytest.raises(UsageError, match="no chip 'z'"):
                await client.request("listing", chip="z")
            with pytest.raises(UsageError, match="do: 'foo'"):
                await client.request("foo")

    asyncio.run(main())


def test_a_token():
    async def main():
        async with served("a long token") as (client, where):
            assert (await client.request("read", pins=[]))["levels"] == {}
            with pytest.raises(UsageError, match="must include the token"):
                await ControlClient.connect(where, "another token")

    asyncio.run(main())


def test_nobody_is_there():
    with pytest.raises(UsageError, match="Connection refused; give the control port of a running server"):
        asyncio.run(ControlClient.connect("127.0.0.1:1"))


def test_replies_come_in_any_order():
    async def main():
        async with script([{"later": 1, "found": 2}, {"found": 1}], {"found": 3}) as client:
            first = asyncio.ensure_future(client.request("one"))
            await asyncio.sleep(0)
            second = asyncio.ensure_future(client.request("two"))
            assert (await second)["found"] == 2
            assert (await first)["found"] == 1

    asyncio.run(main())


def test_a_branch_brings_a_whole_view():
    async def main():
        old, new = {"chips": {"x": {"a": 1, "b": None}}}, {"chips": {"x": {"b": 2}}}
        lines = [
            {"view": old},
            [{"event": "view", "view": {"chips": {"x": {"a": 3}}}}, {"found": 1}],
            [{"event": "branch", "branch": 1}, {"event": "view", "view": new}, {"found": 2}],
        ]
        async with script(*lines) as client:
            await client.subscribe("10 ms")
            await client.request("one")
            assert client.view == {"chips": {"x": {"a": 3, "b": None}}}
            await client.request("two")
            assert client.view == new

    asyncio.run(main())


def test_the_connection_ends():
    async def main():
        async with script() as client:
            with pytest.raises(ConnectionEnded):
                await client.request("one")
            assert not client.open
            with pytest.raises(ConnectionEnded):
                await client.request("two")
            assert [event async for event in client.events()] == []

    asyncio.run(main())


@pytest.mark.parametrize(
    ("old", "new", "both"),
    [
        ({"a": {"b": 1}}, {"a": {"c": 2}}, {"a": {"b": 1, "c": 2}}),
        ({"a": 1}, {"a": None}, {"a": None}),
        ([{"a": 1}, {"b": 2}], [{}, {"b": 3}], [{"a": 1}, {"b": 3}]),
        ([{"a": 1}], [{"a": 1}, {"a": 2}], [{"a": 1}, {"a": 2}]),
        (["one"], ["two"], ["two"]),
        ({"a": 1}, 2, 2),
    ],
)
def test_a_view_with_its_changes(old, new, both):
    assert merged(old, new) == both
