"""Streams: bounded in both directions."""

from __future__ import annotations

import gc
import os
import select
import selectors
import signal
import socket
from types import SimpleNamespace

import pytest

from slewline.links.sockets import system
from slewline.links.sockets.loop import Loop
from slewline.links.sockets.stream import QUEUE, SocketStream

MUCH = bytes(range(256)) * 4096  # a megabyte


class Ends:
    """A stream on one end of a socket pair, and the other end."""

    def __init__(self, **more):
        self.loop = Loop()
        self.ours, self.theirs = socket.socketpair()
        self.taken, self.why = bytearray(), []
        self.stream = SocketStream(self.loop, self.ours, self.taken.extend, self.why.append, **more)

    def turn(self, times=1):
        for _ in range(times):
            self.loop.serve(self.loop.sleep(0))

    def close(self):
        self.stream.close()
        self.loop.close()
        self.ours.close()
        self.theirs.close()


@pytest.fixture
def ends():
    made = []

    def make(**options):
        made.append(Ends(**options))
        return made[-1]

    yield make
    for one in made:
        one.close()


def test_a_reader_that_does_not_read_costs_a_bounded_queue(ends):
    one = ends()
    dropped = one.stream.write(MUCH)
    one.turn(3)
    for start in range(0, len(MUCH), 1000):
        dropped += one.stream.write(MUCH[start : start + 1000])
        assert len(one.stream.outgoing) <= QUEUE
        one.turn()
    assert dropped == one.stream.dropped > 0
    one.theirs.setblocking(False)
    received = bytearray()
    while one.stream.outgoing or not received:
        received += one.theirs.recv(1 << 20)
        one.turn()
    try:
        while data := one.theirs.recv(1 << 20):
            received += data
    except BlockingIOError:
        pass
    assert len(received) + dropped == 2 * len(MUCH)  # every byte is sent, or counted
    assert received[:QUEUE] == MUCH[:QUEUE]


def test_writes_of_a_turn_are_sent_at_its_end(ends):
    one = ends()
    one.stream.write(b"R")
    one.stream.write(b"\r")
    one.theirs.setblocking(False)
    with pytest.raises(BlockingIOError):
        one.theirs.recv(10)
    one.turn()
    assert one.theirs.recv(10) == b"R\r"


def test_an_endless_writer_is_blocked(ends):
    left = [10]
    one = ends(room=lambda: left[0] - len(one.taken))
    one.theirs.send(MUCH[:100])
    one.turn(5)
    assert one.taken == MUCH[:10]
    one.turn(5)
    left[0] = 30
    one.stream.resume()
    one.turn(5)
    assert one.taken == MUCH[:30]


def test_a_blocked_stream_does_not_keep_the_loop_busy(ends):
    one = ends(room=lambda: 0)
    one.theirs.send(b"F")
    one.turn(2)
    assert one.loop.sleep(0) == []


def test_a_closed_stream_reads_nothing_even_if_requested_to_read_now(ends):
    one, other = ends(), ends()
    for each in (one, other):
        each.theirs.send(b"F")
    other.stream.close()
    one.stream.read_now()
    other.stream.read_now()
    assert (one.taken, other.taken) == (b"F", b"")


def test_the_end_is_reported_once(ends):
    one = ends()
    one.theirs.close()
    one.turn(3)
    assert one.why == ["closed the connection"]
    assert one.stream.write(b"R") == 1  # dropped


@pytest.mark.posix
def test_bytes_that_no_client_can_take_any_more_end_the_stream(ends):
    one = ends()
    one.theirs.shutdown(socket.SHUT_RD)
    one.stream.write(b"R")
    one.turn(2)
    assert one.why == [os.strerror(32)]


@pytest.mark.posix
def test_a_client_that_reads_no_more_is_served_to_the_last_byte(ends):
    over = []
    one = ends(ended=lambda: over.append(1))
    one.theirs.send(b"left")
    one.theirs.shutdown(socket.SHUT_RD)
    one.stream.write(b"R")
    one.turn(1)
    assert one.stream.is_shut and one.stream.write(b"R") == 1
    one.turn(2)
    assert (one.taken, over) == (b"left", [])
    one.theirs.close()
    one.turn(2)
    assert (over, one.why) == ([1], [])
    one.stream.finish()
    assert one.why == [os.strerror(32)]


# ------------------------------------------------------------------------------------------- the end, behind bytes
def test_the_end_after_bytes_is_found_by_reading_ahead(ends):
    left = [10]
    over = []
    one = ends(room=lambda: left[0] - len(one.taken), ended=lambda: over.append(1))
    one.theirs.send(MUCH[:1000])
    one.turn(5)
    assert not one.stream.read_ahead(QUEUE) and one.taken == MUCH[:10]
    one.theirs.close()
    assert one.stream.read_ahead(QUEUE) and (one.taken, over) == (MUCH[:10], [])
    for room in (500, 2000):
        left[0] = room
        one.stream.resume()
        one.turn(5)
    assert (one.taken, over) == (MUCH[:1000], [1])  # not a byte is lost or read twice


def test_read_ahead_is_bounded(ends):
    one = ends(room=lambda: 0)
    one.theirs.setblocking(False)
    one.theirs.send(MUCH)
    one.turn()
    for _ in range(100):
        assert one.stream.read_ahead(1000)  # more than that is here, and whoever has it counts as gone
    assert len(one.stream.ahead) < 1000 + QUEUE
    assert one.loop.sleep(0) == []  # and nobody is kept busy by it


def test_one_that_has_vanished_has_closed(ends):
    one = ends(room=lambda: 0)
    one.turn()
    one.theirs.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, b"\1\0\0\0\0\0\0\0")
    one.theirs.close()
    assert one.stream.read_ahead(QUEUE)


# -------------------------------------------------------------------------------------------------------------- loop
@pytest.mark.skipif(not hasattr(selectors, "EpollSelector"), reason="no epoll here")
def test_a_sleep_of_part_of_a_millisecond_is_left_to_select(monkeypatch):
    """epoll rounds each sleep up to whole milliseconds, so it is never given one."""
    slept, asked = [], []
    real = selectors.DefaultSelector.select

    def asks(self, timeout=None):
        asked.append(timeout)
        return real(self, timeout)

    loop = Loop()
    monkeypatch.setattr(select, "select", lambda readers, *_: slept.append((readers, _[-1])))
    monkeypatch.setattr(selectors.DefaultSelector, "select", asks)
    assert loop.sleep(0.0001) == []
    assert slept == [([loop.selector.fileno()], 0.0001)]
    assert loop.sleep(0) == []
    assert (len(slept), asked) == (1, [0, 0])
    loop.close()


def test_a_descriptor_that_is_watched_for_the_same_twice_is_still_read():
    loop = Loop()
    ours, theirs = socket.socketpair()
    read = []

    class Reader:
        def call(self):
            read.append(ours.recv(1))

    reader = Reader()
    for _ in range(2):
        loop.watch(ours.fileno(), reader.call)
    theirs.send(b"x")
    loop.serve(loop.sleep(None))
    assert read == [b"x"]
    loop.close()
    ours.close()
    theirs.close()


def test_a_descriptor_that_was_forgotten_in_this_turn_is_not_read():
    loop = Loop()
    pairs = [socket.socketpair() for _ in range(2)]
    read = []

    def reader(number):
        def call():
            read.append(number)
            loop.watch(pairs[1 - number][0].fileno())

        return call

    for number, (ours, theirs) in enumerate(pairs):
        loop.watch(ours.fileno(), reader(number))
        theirs.send(b"x")
    loop.serve(loop.sleep(0))
    assert len(read) == 1
    loop.close()
    for pair in pairs:
        for end in pair:
            end.close()


def test_calls_of_other_threads_and_timers_wake_the_loop():
    loop = Loop()
    called = []
    loop.after(0.001, lambda: called.append("timer"))
    loop.ask(lambda: called.append("asked"))
    while len(called) < 2:
        loop.serve(loop.sleep(None))
    loop.close()
    assert called == ["asked", "timer"]


def test_a_signal_ends_a_sleep_even_where_the_system_would_sleep_on():
    """On Windows `select` is not interrupted: what Python writes for each signal wakes it."""
    loop = Loop()
    kept = signal.signal(signal.SIGINT, lambda *_: None)
    try:
        loop.watch_signals()
        signal.raise_signal(signal.SIGINT)
        assert [key.fd for key, _ in loop.sleep(10)] == [loop.wakeup.fileno()]
        loop.close()
        assert signal.set_wakeup_fd(-1) == -1
    finally:
        signal.signal(signal.SIGINT, kept)


def test_a_loop_that_is_forgotten_leaves_no_socket_open():
    loop = Loop()
    ends = loop.wakeup, loop.button
    del loop
    gc.collect()
    assert [end.fileno() for end in ends] == [-1, -1]


def test_a_fine_timer_of_windows_is_requested_while_it_is_needed(monkeypatch):
    asked = []
    timer = SimpleNamespace(
        timeBeginPeriod=lambda ms: asked.append(("begin", ms)), timeEndPeriod=lambda ms: asked.append(("end", ms))
    )
    monkeypatch.setattr(system, "multimedia", lambda: timer)
    with pytest.raises(RuntimeError), system.fine_timer():
        raise RuntimeError
    assert asked == [("begin", 1), ("end", 1)]
