"""The way back: every instant of a session is as it was, to the bit, whatever came from outside."""

from __future__ import annotations

import os
import random
import time

import pytest

from slewline.bench import replay

from .conftest import STRAPS, Asks, children, until
from .test_branches import alive

pytestmark = [
    pytest.mark.system,
    pytest.mark.skipif(not hasattr(os, "fork"), reason="the system cannot copy a process"),
]

PORTS = ("--tcp", "127.0.0.1:0", "--control", "127.0.0.1:0")
MODULE = ("gs-c200s", *(f"--strap={pin}={level}" for pin, level in STRAPS.items()))
CHIP = "gs_c200s"
PROGRAM = ("Po", "S50", "T200", "R20", "+400", "E")
COMMANDS = ("V1", "V2", "F", "E", "X", "S300", "R50", "T900", "Z", "H", "W", "HELLO", "+100", "A1", "C1")


def everything(ask):
    """All that a client can know of a server at this instant."""
    status, view = ask("status"), ask("view")["view"]
    view["pace"] = status["pace"] = None
    for line in status["lines"].values():  # counts of a connection, of which a branch has its own
        for key in ("host", "taken", "given", "dropped", "hits"):
            line.pop(key, None)
    now = status["time_ps"]
    steps = ask("steps", chip=CHIP, start=max(now - 200_000_000_000, 0))
    said = ask("said", start=max(view["entries"] - 100, 0))["entries"]
    return now, status, view, said, steps


class Session:
    """A host, pins and faults by chance, on a server that is asked about itself at random instants."""

    def __init__(self, serve, client, folder, seed, rate):
        self.chance = random.Random(seed)
        self.server = serve(*MODULE, *PORTS, "--rate", rate, "--journal", folder / "journal", ports=2)
        self.journal = folder / "journal"
        self.ask = Asks(client(self.server.ports["control"]))
        self.host = client(self.server.ports[CHIP])

    def say(self, text):
        self.host.send(text.encode() + b"\r")

    def act(self):
        """Do something from outside."""
        chance = self.chance.random()
        if chance < 0.6:
            self.say(self.chance.choice(COMMANDS))
        elif chance < 0.8:
            pin = f"{CHIP}.{self.chance.choice(('ui1', 'ui2', 'ui3', 'enable', 'eot'))}"
            self.ask("drive", pin=pin, level=self.chance.randrange(2))
        elif chance < 0.9:
            kind = self.chance.choice(("parity", "framing", "lost", "garbled"))
            self.ask("fault", line=CHIP, to="chip", kind=kind, count=self.chance.randrange(1, 4), seed=1)
        elif chance < 0.97:
            self.ask("release", pin=f"{CHIP}.{self.chance.choice(('ui1', 'ui2', 'ui3', 'enable', 'eot'))}")
        else:
            self.ask("power", chip=CHIP, on=False)
            self.ask("power", chip=CHIP, on=True)

    def play(self, acts, looks):
        """Play a session; return what was known at some instants of it."""
        for line in PROGRAM:
            self.say(line)
            time.sleep(0.005)
        seen, per_act = [], looks / acts
        owed = 0.0
        for _ in range(acts):
            self.act()
            time.sleep(self.chance.random() * 0.01)
            owed += per_act
            while owed >= 1:
                owed -= 1
                self.ask("pause")
                level = self.chance.randrange(2)
                self.ask("drive", pin=f"{CHIP}.ui1", level=level)  # at the very instant: it belongs to it
                seen.append(everything(self.ask))
                self.ask("go")
                time.sleep(self.chance.random() * 0.004)
        self.ask("pause")
        return seen


@pytest.fixture
def begin(serve, client, tmp_path):
    """Begin a session."""
    return lambda seed, rate="20": Session(serve, client, tmp_path, seed, rate)


def there_and_back(session, seen):
    """Go back to each instant in random order, compare; return how long each took, in seconds."""
    took = []
    for now, *before in session.chance.sample(seen, len(seen)):
        start = time.perf_counter()
        found = session.ask("back", time=now, branch=0)
        took.append(time.perf_counter() - start)
        assert "error" not in found, found
        assert found["time_ps"] == now
        assert [*everything(session.ask)][1:] == before
    return took


def test_every_instant_of_a_session_is_as_it_was(begin):
    session = begin(seed=1)
    seen = session.play(acts=40, looks=20)
    there_and_back(session, seen)


@pytest.mark.long
@pytest.mark.parametrize("seed", range(5))
def test_a_thousand_instants_of_long_sessions_are_as_they_were(begin, seed):
    session = begin(seed=seed, rate="30")
    seen = session.play(acts=1000, looks=200)
    took = sorted(there_and_back(session, seen))
    middle, worst = took[len(took) // 2], took[-1]
    print(f"{seen[-1][0] / 1e12:.0f} s of session: back in {middle * 1e3:.0f} ms, at worst {worst * 1e3:.0f} ms")


def test_a_branch_continues_by_itself_and_the_first_run_is_unchanged(begin):
    session = begin(seed=2, rate="1")
    ask = session.ask
    for line in PROGRAM:
        session.say(line)
    for _ in PROGRAM:
        assert session.host.read() == b"Y\r"
    ask("until", chip=CHIP, position=400)
    ask("pause")
    there = ask("steps", chip=CHIP)["times_ps"][-1]
    end = everything(ask)
    assert ask("back", time=there - 10**11)["branch"] == 1
    before = ask("view")["view"]["chips"][CHIP]["axes"][0]["position"]
    assert before < 400
    ask("drive", pin=f"{CHIP}.enable", level=0)
    ask("until", time=end[0] + 10**12)
    assert ask("view")["view"]["chips"][CHIP]["axes"][0]["position"] < 400
    branches = ask("branches")
    assert [row["number"] for row in branches["branches"]] == [0, 1] and branches["current"] == 1
    assert ask("back", time=there - 10**11, branch=1)["branch"] == 2  # of the branch, where nothing was driven yet
    assert ask("view")["view"]["chips"][CHIP]["axes"][0]["position"] == before
    ask("branch", number=0)
    assert [*everything(ask)] == [*end]


def test_the_host_speaks_to_the_branch_that_is_shown(begin):
    session = begin(seed=3, rate="1")
    assert session.host.ask(b"V1\r") == b"V+0\r"
    session.ask("pause")
    now = session.ask("view")["time_ps"]
    session.ask("back", time=now)
    session.ask("go")
    assert session.host.ask(b"HELLO\r") == b"E2\r"
    branch = session.ask("said")["entries"]
    session.ask("branch", number=0)
    assert "HELLO" not in str(session.ask("said")["entries"]) and "HELLO" in str(branch)
    session.ask("go")
    assert session.host.ask(b"V1\r") == b"V+0\r"


def test_the_journal_of_a_session_has_the_first_run_only(begin):
    session = begin(seed=4)
    session.play(acts=30, looks=5)
    end = everything(session.ask)
    session.ask("back", time=end[0] // 2)
    for _ in range(10):
        session.act()
    session.server.end()
    bench = replay(session.journal, until=f"{end[0]} ps")
    assert bench.now_ps == end[0]
    assert bench[CHIP].position == end[1]["chips"][CHIP]["position"]
    assert len(bench.findings) == end[1]["findings"]


def test_instants_that_have_not_come_and_branches_that_are_not_there_are_refused(begin):
    session = begin(seed=5)
    assert "is in the future" in session.ask("back", time="1000 s")["error"]
    assert session.ask("back", time="0 s", branch=7)["error"] == "no branch 7; allowed: 0"
    assert session.ask("branch", number=3)["error"] == "no branch 3; allowed: 0"


def test_without_a_journal_there_is_no_return(serve, client):
    server = serve(*MODULE, *PORTS, ports=2)
    ask = Asks(client(server.ports["control"]))
    assert "--journal FILE" in ask("back", time=0)["error"]


def test_all_processes_end_with_the_server(begin):
    session = begin(seed=6)
    session.play(acts=40, looks=2)
    session.ask("back", time="30 ms")
    group = children(session.server.process.pid)
    assert group
    session.server.kill()
    until(lambda: not any(map(alive, group)))


def test_a_client_that_stops_reading_in_a_branch_delays_nothing(begin, client):
    session = begin(seed=9)
    session.play(acts=5, looks=0)
    session.ask("subscribe", every="5 ms")
    session.ask("back", time="20 ms")
    session.ask("subscribe", every=0)
    time.sleep(0.05)  # in which the server would look for changes without end
    other = Asks(client(session.server.ports["control"]))
    assert other("branches")["branches"]


def test_a_branch_that_was_only_looked_at_is_not_kept_and_one_that_was_touched_is(begin):
    ask = begin(seed=7).ask
    ask("until", time="200 ms")
    looked_at = ask("back", time="100 ms")["branch"]
    assert "A 0" in ask("example", name="programs/weld.cy525")["text"]
    touched = ask("back", time="100 ms", branch=0)["branch"]
    ask("drive", pin=f"{CHIP}.enable", level=0)
    ask("back", time="50 ms", branch=0)
    numbers = [row["number"] for row in ask("branches")["branches"]]
    assert touched in numbers and looked_at not in numbers
