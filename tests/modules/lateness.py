"""How late a proxy passes characters on: fed at 9600 baud in both directions, beside busy processes.

    python -m tests.modules.lateness pty|tcp SECONDS [PROCESSES]     prints histograms

A character's lateness is the time from its write at one end to its read at the other; so the wake-up of the reading
process is in it, too, and whatever the line itself takes: that is measured at the same time, without a proxy.
"""

from __future__ import annotations

import os
import socket
import subprocess
import sys
import time
import tty
from contextlib import ExitStack, contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

from slewline.links.sockets.system import be_prompt

CHARACTER_NS = 11 * 10**9 // 9600  # of 7O2
BUSY = "while True: pass"
SETTLE_S = 0.3
EDGES_US = (50, 100, 200, 500, 1000, 2000, 5000)


def feed(fd, count):
    """Write a character every 1.146 ms; print when each was written."""
    be_prompt()
    time.sleep(SETTLE_S)
    due, sent = time.monotonic_ns(), []
    for number in range(count):
        due += CHARACTER_NS
        while (left := due - time.monotonic_ns()) > 0:
            time.sleep(left / 1e9)
        sent.append(time.monotonic_ns())
        os.write(fd, bytes([0x20 + number % 64]))
    print(*sent)


def hear(fd, count):
    """Read characters; print when each was read."""
    be_prompt()
    got = []
    while len(got) < count:
        data = os.read(fd, 64)
        got += [time.monotonic_ns()] * len(data)
    print(*got)


def helper(what, fd, count):
    """Start one of these in a process of its own."""
    call = [sys.executable, "-m", "tests.modules.lateness", what, str(fd), str(count)]
    return subprocess.Popen(call, stdout=subprocess.PIPE, pass_fds=[fd], text=True)


@contextmanager
def busy(processes):
    """Keep the machine busy."""
    loads = [subprocess.Popen([sys.executable, "-c", BUSY]) for _ in range(processes)]
    try:
        yield
    finally:
        for load in loads:
            load.kill()
            load.wait()


@contextmanager
def proxied(kind, folder):
    """Yield both ends of a proxy, as descriptors: on ptys, or on sockets."""
    call = [sys.executable, "-m", "slewline", "proxy", "--part", "gs-c200s", "--dialogue", folder / "record.dialogue"]
    with ExitStack() as stack:
        if kind == "pty":
            master, slave = os.openpty()
            tty.setraw(slave)
            stack.callback(os.close, slave)
            stack.callback(os.close, master)
            call += ["--serial", os.ttyname(slave), "--pty", folder / "host"]
        else:
            listener = stack.enter_context(socket.create_server(("127.0.0.1", 0)))
            call += ["--serial", f"socket://127.0.0.1:{listener.getsockname()[1]}", "--tcp", "127.0.0.1:0"]
        proxy = subprocess.Popen(call, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        stack.callback(proxy.communicate)
        stack.callback(proxy.terminate)
        where = proxy.stdout.readline().split()[1]
        if kind == "pty":
            host = os.open(where, os.O_RDWR | os.O_NOCTTY)
            stack.callback(os.close, host)
            yield master, host
        else:
            ends = listener.accept()[0], socket.create_connection(where.rpartition("/")[2].split(":"))
            for end in map(stack.enter_context, ends):
                end.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            ends[1].send(b"\r")  # what a connection begins with is passed on when its first line is over
            assert ends[0].recv(1) == b"\r"
            yield ends[0].fileno(), ends[1].fileno()


@contextmanager
def direct(kind, _folder):
    """Yield both ends of a pty, or of a pair of sockets, as descriptors."""
    if kind == "pty":
        ends = os.openpty()
        tty.setraw(ends[1])
        yield ends
        for end in ends:
            os.close(end)
    else:
        with ExitStack() as stack:
            yield tuple(each.fileno() for each in map(stack.enter_context, socket.socketpair()))


def measured(kind, seconds, processes=2):
    """Return the lateness of characters in us: directly, through a proxy to the host, and through it to the module."""
    count = int(seconds * 1e9) // CHARACTER_NS
    with TemporaryDirectory() as name, ExitStack() as stack:
        folder = Path(name)
        near, far = stack.enter_context(direct(kind, folder))
        module, host = stack.enter_context(proxied(kind, folder))
        stack.enter_context(busy(processes))
        pairs = [(near, far), (module, host), (host, module)]
        ears = [helper("hear", end, count) for _, end in pairs]
        mouths = [helper("feed", end, count) for end, _ in pairs]
        times = [[list(map(int, one.communicate()[0].split())) for one in all_] for all_ in (mouths, ears)]
    return [[(got - sent) / 1000 for sent, got in zip(*pair, strict=True)] for pair in zip(*times, strict=True)]


def histogram(late_us):
    """Return the rows of a table: how many characters were not later than each edge, but later than the one before."""
    rows, before = [], 0
    for edge in (*EDGES_US, float("inf")):
        rows.append((edge, sum(before < late <= edge for late in late_us)))
        before = edge
    return rows


def share_us(late_us, share):
    """Return the lateness that so much of all characters do not exceed."""
    return sorted(late_us)[int(len(late_us) * share)]


def main(what, *arguments):
    """Do what the command line asks for."""
    if what in ("feed", "hear"):
        {"feed": feed, "hear": hear}[what](*map(int, arguments))
        return
    found = measured(what, *map(int, arguments))
    for name, late in zip(("direct", "to the host", "to the module"), found, strict=True):
        shares = ", ".join(f"{share:.1%} {share_us(late, share):.0f} us" for share in (0.5, 0.9, 0.99, 0.999))
        print(f"{what}, {name}: {len(late)} characters, {shares}, worst {max(late):.0f} us")
        print("   " + "  ".join(f"<={edge}: {count}" for edge, count in histogram(late)))


if __name__ == "__main__":
    main(*sys.argv[1:])
