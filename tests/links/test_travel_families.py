"""The way back, for every family of chips: each instant is as it was, and nothing outside notices the branches."""

from __future__ import annotations

import json
import os
import random
import signal
import socket
import time
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import pytest

from slewline.links.clients.chipset_host import ChipsetHost

from .conftest import PATIENCE, STRAPS, Asks

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="the system cannot copy a process")

SERVE = '[[serve]]\ntcp = "127.0.0.1:0"\n'
FREE = "straps = { br0 = 0, br1 = 0, br2 = 0, chs = 0"
MODULES = "".join(
    f'[[chip]]\npart = "gs-c200s"\nname = "{name}"\n{FREE}, sel{sel} = 0 }}\n' for sel, name in enumerate("abc")
)


@dataclass(frozen=True)
class Family:
    """A bench, and what a host, hands and a supply do there."""

    bench: str
    said: tuple[str, ...]  # lines of hosts, in any order
    first: tuple[str, ...] = ()  # said before them
    pins: tuple[str, ...] = ()
    acts: tuple[tuple[str, str, tuple[object, ...]], ...] = ()
    end: str = "\r"
    lockstep: bool = True


FAMILIES = {
    "cy525": Family(
        '[[chip]]\npart = "cy525"\nname = "x"\n' + SERVE + "framing = true\n",
        ("E", "N 300", "R 120", "F 80", "S 1", "G", "+", "-", "A", "D", "H", "?0", "?1", "Q", "I", "HELLO", "?"),
        ("F 80", "R 100", "S 1", "N 200", "+"),
        ("x.dowhile", "x.wait", "x.abort", "x.xy"),
    ),
    "cy545": Family(
        '[[chip]]\npart = "cy545b"\nname = "x"\n'
        '[[part]]\nkind = "ram"\nname = "ram"\nto = "x"\n'
        '[[part]]\nkind = "jog_switch"\nname = "jog"\nto = "x"\n'
        '[[part]]\nkind = "hp_display"\nname = "display"\nto = "x"\n'
        '[[serve]]\nover = "serial"\ntcp = "127.0.0.1:0"\n[[serve]]\nover = "parallel"\ntcp = "127.0.0.1:0"\n',
        ("+", "-", "N 200", "R 200", "G", "? P", "? R", "O 95H", "O 81H", "Y 0", "E", "Q", "X", "0", "D 20", "HELLO"),
        ("\r\r", "S 50", "N 400", "R 150"),
        ("x.usrb0", "x.cw_limit", "x.wait"),
        (("jog", "cw", ()), ("jog", "off", ()), ("jog", "ccw", ())),
    ),
    "modules": Family(
        MODULES + '[[serve]]\nchips = ["a", "b", "c"]\ntcp = "127.0.0.1:0"\n',
        tuple(n + line for n in "653" for line in ("V1", "F", "E", "X", "M", "S300", "T900", "Z", "H", "W", "+90")),
        tuple(n + line for n in "653" for line in ("Po", "S50", "T200", "R20", "+400", "-90", "Px")),
        ("a.ui1", "b.enable", "c.eot", "b.ui2"),
    ),
    "mc1451a": Family(
        '[[chip]]\npart = "mc1451a"\nname = "x"\n' + SERVE,
        (
            "SET_POS 5000", "SET_POS -300", "SET_VEL 50000", "SET_ACC 1000", "UPDATE", "SET_1", "SET_2", "STOP",
            "SET_PRFL_VEL", "SET_PRFL_TRAP", "SET_PRFL_S_CRV", "SET_JERK 400000", "SET_ACTL_POS 0", "RESET",
        ),
        ("SET_1", "SET_PRFL_TRAP", "SET_VEL 100000", "SET_ACC 1000", "SET_POS 5000", "UPDATE"),
        ("x.home1", "x.poslimit1", "x.neglimit2", "x.home3"),
    ),
}  # fmt: skip


def everything(ask):
    """All that a client can know of a server at this instant."""
    status, view = ask("status"), ask("view")["view"]
    view["pace"] = status["pace"] = None
    for line in status["lines"].values():  # counts of a connection, of which a branch has its own
        for key in ("host", "taken", "given", "dropped", "hits"):
            line.pop(key, None)
    said = ask("said", start=max(view["entries"] - 60, 0))["entries"]
    pins = ask("signals")["pins"]
    levels = ask("read", pins=[f"{owner}.{pin}" for owner, names in pins.items() for pin in names])["levels"]
    listings = {chip: ask("listing", chip=chip)["rows"] for chip in view["chips"]}
    steps = {
        (chip, axis): [ask("steps", chip=chip, axis=axis, start=max(status["time_ps"] - 10**10, 0))]
        for chip, row in status["chips"].items()
        for axis in range(1, len(row["axes"]) + 1)
    }
    return {
        "status": status,
        "view": view,
        "said": said,
        "levels": levels,
        "listings": listings,
        "steps": steps,
        "findings": ask("findings"),
    }


class Session:
    """A session by chance on a server of a family."""

    def __init__(self, serve, client, folder, name, seed, *more):
        self.family, self.chance = FAMILIES[name], random.Random(seed)
        bench = folder / "bench.toml"
        bench.write_text(self.family.bench)
        count = self.family.bench.count("[[serve]]") + 1
        self.journal, self.state = folder / "journal", folder / "state"
        self.server = serve(
            "--bench",
            bench,
            "--control",
            "127.0.0.1:0",
            "--journal",
            self.journal,
            "--state",
            self.state,
            *more,
            ports=count,
        )
        self.lockstep = "--lockstep" in more
        self.ask = Asks(client(self.server.ports["control"]))
        ports = [where for port, where in self.server.ports.items() if port != "control"]
        sockets = [where for where in ports if where.startswith("socket:")]
        self.host = client(sockets[0]) if sockets else None
        self.chipset, self.sent = None, 0
        if not sockets:
            host, port = ports[0].rpartition("//")[2].rsplit(":", 1)
            self.chipset = ChipsetHost(host, int(port))
        self.chip = next(iter(self.ask("view")["view"]["chips"]))

    def say(self, line):
        if self.chipset is None:
            data = line.encode() + self.family.end.encode()
            self.host.send(data)
            self.sent += len(data)
        else:
            self.chipset.send(line)

    def act(self):
        """Do something from outside."""
        ask, family, chance = self.ask, self.family, self.chance
        kind = chance.random()
        if kind < 0.6:
            self.say(chance.choice(family.said))
        elif kind < 0.75:
            for pin in chance.sample(family.pins, chance.randrange(1, 3)):  # at one instant, if time stands
                ask("drive", pin=pin, level=chance.randrange(2))
        elif kind < 0.83:
            ask("release", pin=chance.choice(family.pins))
        elif kind < 0.88:
            ask("pulse", pin=chance.choice(family.pins), level=0, width=chance.choice(("3 us", "2 ms")))
        elif kind < 0.93 and family.acts:
            part, verb, args = chance.choice(family.acts)
            ask("act", part=part, verb=verb, args=args)
        elif kind < 0.97 and self.host is not None:
            line = next(iter(ask("status")["lines"]))
            ask("fault", line=line, to="chip", kind="parity", count=chance.randrange(1, 4), seed=1)
        else:
            ask("power", chip=self.chip, on=False)
            if chance.random() < 0.5:
                self.say_nothing()
            ask("power", chip=self.chip, on=True)

    def say_nothing(self):
        if self.lockstep:
            self.ask("advance", time=self.chance.randrange(1, 30 * 10**9))
        else:
            time.sleep(self.chance.random() * 0.008)

    def take_all(self):
        """Wait until the server has taken what hosts have sent: it belongs to this instant."""
        taken = None
        while taken != (taken := [line["taken"] for line in self.ask("status")["lines"].values()]):
            time.sleep(0.02)

    def play(self, acts, looks):
        """Play; return what was known at some instants."""
        for line in self.family.first:
            self.say(line)
            self.say_nothing()
        seen = []
        for number in range(acts):
            self.act()
            self.say_nothing()
            if number % (acts // looks) == 0:
                self.ask("pause")
                self.take_all()
                for _ in range(self.chance.randrange(3)):  # inputs at one instant, which has passed
                    self.ask("drive", pin=self.chance.choice(self.family.pins), level=self.chance.randrange(2))
                seen.append(everything(self.ask))
                self.ask("go")
                self.say_nothing()
        if self.host is not None and not self.lockstep:  # what is left would be said in the branches
            self.ask("go", rate="100")
            until(lambda: next(iter(self.ask("status")["lines"].values()))["taken"] == self.sent)
        self.ask("pause")
        return seen


def differences(one, other, path=""):
    """Where two of them differ."""
    if isinstance(one, dict) and isinstance(other, dict):
        return [
            d for key in one.keys() | other.keys() for d in differences(one.get(key), other.get(key), f"{path}/{key}")
        ]
    if isinstance(one, list) and isinstance(other, list) and len(one) == len(other):
        return [d for n, pair in enumerate(zip(one, other, strict=True)) for d in differences(*pair, f"{path}/{n}")]
    return [] if one == other else [f"{path}: {one!r:.300} is now {other!r:.300}"]


def compare(session, seen):
    for before in session.chance.sample(seen, len(seen)):
        now = before["status"]["time_ps"]
        found = session.ask("back", time=now, branch=0)
        assert found.get("time_ps") == now and "error" not in found, found
        assert differences(before, everything(session.ask)) == []


@pytest.fixture
def begin(serve, client, tmp_path):
    """Begin a session of a family."""
    made = []

    def start(name, seed, *more):
        made.append(Session(serve, client, tmp_path, name, seed, *more))
        return made[-1]

    yield start
    for session in made:
        if session.chipset is not None:
            session.chipset.close()


PACES = [("--rate", "5"), ("--lockstep",)]


@pytest.mark.parametrize("pace", PACES, ids=lambda pace: pace[0])
@pytest.mark.parametrize("name", FAMILIES)
def test_every_instant_is_as_it_was(begin, name, pace):
    session = begin(name, 1, *pace)
    seen = session.play(acts=24, looks=4)
    assert len({repr(one["levels"]) for one in seen}) > 1
    compare(session, seen)


@pytest.mark.long
@pytest.mark.parametrize("seed", range(2, 6))
@pytest.mark.parametrize("pace", [*PACES, ("--rate", "0.05"), ("--rate", "1000")], ids="".join)
@pytest.mark.parametrize("name", FAMILIES)
def test_every_instant_of_longer_sessions_is_as_it_was(begin, name, pace, seed):
    session = begin(name, seed, *pace)
    compare(session, session.play(acts=150, looks=25))


# ------------------------------------------------------------------------------------------------ branches of branches
ONE = ("gs-c200s", *(f"--strap={pin}={level}" for pin, level in STRAPS.items()))
X = "gs_c200s"
LONG = ("Po", "S50", "T900", "R20", "L0", "+9", "-8", "L255", "E")  # moves again and again


class Module:
    """A server with one module, on a TCP port."""

    def __init__(self, serve, client, folder, *more):
        ports = ("--tcp", "127.0.0.1:0", "--control", "127.0.0.1:0")
        self.server = serve(*ONE, *ports, "--journal", folder / "journal", *more, ports=2)
        self.client = client
        self.ask, self.host = self.another(), client(self.server.ports[X])

    def another(self):
        """Another client of the control port."""
        return Asks(self.client(self.server.ports["control"]))

    def position(self):
        return self.ask("view")["view"]["chips"][X]["axes"][0]["position"]

    def begin(self, *lines):
        for line in lines:
            self.host.ask(line.encode() + b"\r")

    def worlds(self):
        """Processes of worlds: those whose parents are checkpoints."""
        return [child for one in children(self.server.process.pid) for child in children(one)]

    def descriptors(self):
        return len(os.listdir(f"/proc/{self.server.process.pid}/fd"))


@pytest.fixture
def module(serve, client, tmp_path):
    """Start a server with one module."""
    return lambda *more: Module(serve, client, tmp_path, *more)


def children(process):
    """The processes that a process has begun, those that have ended without notice too."""
    found = []
    for name in filter(str.isdigit, os.listdir("/proc")):
        try:
            _, parent = Path(f"/proc/{name}/stat").read_text().rpartition(")")[2].split()[:2]
            if int(parent) == process:
                found += [int(name)]
        except OSError:
            pass
    return found


def alive(process):
    """Is it there, and not only to be taken notice of?"""
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def until(met):
    """Wait for something."""
    end = time.monotonic() + PATIENCE
    while not met():
        assert time.monotonic() < end
        time.sleep(0.01)


def test_a_branch_has_a_past_of_its_own_even_where_no_input_tells_it_from_the_first_run(module):
    x = module("--rate", "200")
    x.begin("Po", "S50", "T900", "R20", "+9000", "E")
    names = list(x.ask("view")["view"]["chips"][X]["registers"])
    never = [{"chip": X, "register": name, "value": -12345} for name in names]
    x.ask("breakpoints", breakpoints=(never * 256)[:256])  # which makes work of looking
    x.ask("pause")
    begin, before = x.ask("view")["time_ps"], len(children(x.server.process.pid))
    end = begin
    while len(children(x.server.process.pid)) < before + 5:  # checkpoints behind the last input
        end += 10**9
        assert x.ask("until", time=end)["met"]
    third, half = begin + (end - begin) // 3, begin + (end - begin) // 2
    x.ask("back", time=third)
    x.ask("power", chip=X, on=False)
    x.ask("until", time=end)
    off = everything(x.ask)
    x.ask("back", time=end)
    assert differences(off, everything(x.ask)) == []
    x.ask("back", time=half, branch=0)
    assert x.ask("view")["view"]["chips"][X]["powered"]
    x.ask("back", time=half, branch=1)
    assert not x.ask("view")["view"]["chips"][X]["powered"]


def test_two_clients_that_go_back_at_once_come_to_their_own_instants(module):
    x = module("--rate", "50")
    x.begin("Po", "S50", "T200", "R20", "+400", "E")
    time.sleep(0.2)
    x.ask("pause")
    now, other = x.ask("view")["time_ps"], x.another()
    for number in range(1, 9):
        late, early = now * (20 - number) // 20, now // (number + 10)
        for ask, at in ((x.ask, late), (other, early)):
            ask.client.send(json.dumps({"do": "back", "time": at, "branch": 0}).encode() + b"\n")
        one, two = x.ask.answer(), other.answer()
        assert (one["time_ps"], two["time_ps"]) == (late, early)
        shown = x.ask("branches")["current"]
        assert x.ask("view")["time_ps"] == (late if shown == one["branch"] else early)


def test_what_is_refused_changes_nothing(module):
    x = module()
    assert "has not come" in x.ask("back", time="1000 s")["error"]
    assert not x.ask("view")["view"]["pace"]["paused"]
    x.ask("pause")
    x.ask("back", time="1 ms")
    x.ask("go")
    for wrong in ([1], True, "1", 1.0, 7):
        assert x.ask("back", time="1 ms", branch=wrong)["error"] == f"no branch {wrong!r}; there are: 0, 1"
        assert x.ask("branch", number=wrong)["error"].startswith(f"no branch {wrong!r}; there are: 0, ")
    assert "has not come" in x.ask("back", time="1000 s", branch=0)["error"]
    x.ask("go")
    assert "has not come" in x.ask("back", time="1000 s")["error"]
    before = x.ask("branches")
    assert not x.ask("view")["view"]["pace"]["paused"]  # neither of them lets a branch stand
    assert x.ask("view")["time_ps"] > before["time_ps"]


def test_who_waits_in_a_branch_is_told_when_another_one_is_shown(module):
    x = module()
    x.ask("pause")
    x.ask("back", time="1 ms")
    x.ask("go", rate="0.001")
    other = x.another()
    other.client.send(b'{"do": "until", "chip": "gs_c200s", "position": 7, "timeout": "1000 s", "id": 7}\n')
    assert x.ask("view")["view"]["pace"]["rate"] == 0.001
    time.sleep(0.05)
    x.ask("branch", number=0)
    found = other.answer()
    assert found["id"] == 7 and found["error"] == "until: another branch is shown now"
    assert other("view")["view"]["pace"]["branch"] == 0


@pytest.mark.parametrize("shown", [True, False])
def test_a_branch_that_is_killed_leaves_the_first_run(module, shown):
    x = module()
    x.ask("pause")
    now = x.ask("view")["time_ps"]
    x.ask("back", time="1 ms")
    x.ask("drive", pin=f"{X}.ui1", level=0)
    if not shown:
        x.ask("branch", number=0)
    (world,) = x.worlds()
    os.kill(world, signal.SIGKILL)
    until(lambda: len(x.ask("branches")["branches"]) == 1)
    assert x.ask("view")["time_ps"] == now
    assert x.ask("branch", number=1)["error"] == "no branch 1; there are: 0"
    assert x.ask("back", time="1 ms")["branch"] == 2
    x.ask("go")
    assert x.host.ask(b"V1\r") == b"V+0\r"


def test_checkpoints_that_are_killed_are_missed_and_the_server_goes_on(module):
    x = module()
    x.begin("V1")
    x.ask("pause")
    for process in children(x.server.process.pid):
        os.kill(process, signal.SIGKILL)
    for _ in range(3):
        assert "has ended" in x.ask("back", time="1 ms")["error"]
    x.ask("go")
    assert x.host.ask(b"V1\r") == b"V+0\r"
    assert not children(x.server.process.pid)  # none is left that nobody has taken notice of


def test_a_world_that_is_killed_on_its_way_is_told(module):
    x = module()
    x.begin(*["V1"] * 40)
    for process in children(x.server.process.pid)[1:]:
        os.kill(process, signal.SIGKILL)  # so that it takes its time
    until(lambda: len(children(x.server.process.pid)) == 1)
    x.ask("pause")
    (mark,) = children(x.server.process.pid)
    os.kill(mark, signal.SIGSTOP)
    x.ask.client.send(json.dumps({"do": "back", "time": x.ask("view")["time_ps"]}).encode() + b"\n")
    time.sleep(0.1)
    os.kill(mark, signal.SIGCONT)
    until(lambda: children(mark))
    os.kill(children(mark)[0], signal.SIGKILL)
    found = x.ask.answer()
    assert "error" not in found or found["error"].startswith("back: ")
    assert x.ask("back", time="1 ms")["time_ps"] == 10**9


# ------------------------------------------------------------------------------------------------------- the outside
def test_nothing_that_was_said_while_a_branch_was_shown_is_lost_or_comes_twice(module):
    x = module("--rate", "100")
    got, phases = 0, (None, 1, 0, 1, 0)
    for phase in phases:
        if phase is not None:
            x.ask("pause")
            x.ask("back", time=x.ask("view")["time_ps"]) if got == 20 else x.ask("branch", number=phase)
            x.ask("go")
        before = x.ask("view")["view"]["entries"]
        x.host.send(b"V1\r" * 20)  # more than the module takes
        until(lambda before=before: before < x.ask("view")["view"]["entries"])
        time.sleep(0.1)
        said = x.ask("said", start=before)["entries"]
        got += sum(entry["text"].count("\\r") for entry in said if entry["kind"] == "got")
        if phase is None:
            first = got
            got = 20
    x.ask("branch", number=1)
    x.host.socket.settimeout(0.5)
    found = b""
    with suppress(TimeoutError):
        while data := x.host.socket.recv(4096):
            found += data
    assert found == b"V+0\r" * (got - 20 + first)


def test_a_host_whose_line_was_full_goes_on_in_the_branch_and_back(module):
    x = module("--rate", "100")
    x.ask("pause")
    x.host.send(b"V1\r" * 2000)  # the line takes 256 characters, and time stands
    until(lambda: x.ask("status")["lines"][X]["taken"] >= 256)
    x.ask("back", time=0)
    x.ask("go")
    assert x.host.read(b"V+0\r" * 2)
    until(lambda: x.ask("status")["lines"][X]["taken"] > 4000)
    x.ask("branch", number=0)
    x.ask("go")
    x.host.socket.settimeout(10)
    assert x.host.read(b"V+0\r" * 50)


def test_no_file_changes_while_a_branch_is_shown(module, tmp_path):
    state = tmp_path / "state"
    x = module("--rate", "20", "--state", state, "--log", tmp_path / "log")
    x.begin("Po", "S50", "Px", "M")

    def disk():
        return {path.name: path.read_bytes() for path in [*state.iterdir(), tmp_path / "journal", tmp_path / "log"]}

    x.ask("pause")
    before, now = disk(), x.ask("view")["time_ps"]
    x.ask("back", time=now // 2)
    x.ask("go")
    for line in (b"Po\r", b"T900\r", b"Px\r", b"M\r", b"HELLO\r", b"X\r"):
        assert x.host.ask(line)
    x.ask("power", chip=X, on=False)
    x.ask("power", chip=X, on=True)
    assert disk() == before
    x.ask("branch", number=0)
    assert disk() == before or disk()["log"] != before["log"]
    x.ask("go")
    x.begin("Po", "T300", "Px", "M")
    assert disk()["journal"] != before["journal"] and {**disk(), "log": 0, "journal": 0} != {
        **before,
        "log": 0,
        "journal": 0,
    }


def folder_of(x):
    """The folder of the journals of its branches: the journal of a world has its path."""
    (world, *_) = x.worlds()
    open_files = [os.readlink(f"/proc/{world}/fd/{name}") for name in os.listdir(f"/proc/{world}/fd")]
    return next(Path(name).parent for name in open_files if name.endswith("branch1"))


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT, signal.SIGHUP, signal.SIGKILL])
def test_no_process_and_no_file_stays_behind(module, number):
    x = module()
    x.ask("pause")
    x.ask("until", time="5 ms")
    for at in ("1 ms", "2 ms", "3 ms"):
        x.ask("back", time=at, branch=0)
        x.ask("drive", pin=f"{X}.ui1", level=0)
        x.ask("go")
    marks = children(x.server.process.pid)
    group, folder = [*marks, *x.worlds()], folder_of(x)
    assert len(x.worlds()) == 3
    status, err = x.server.end(number)
    assert (status, err) == ((-9, "") if number == signal.SIGKILL else (0, ""))
    until(lambda: not any(alive(process) for process in group))
    assert folder.exists() == (number == signal.SIGKILL)
    for path in folder.glob("*") if folder.exists() else ():
        path.unlink()
    if folder.exists():
        folder.rmdir()


def test_many_ways_back_leave_nothing_open(module):
    x = module("--rate", "20")
    x.begin("Po", "S50", "T200", "R20", "+400", "E")
    x.ask("pause")
    now = x.ask("view")["time_ps"]
    x.ask("back", time=now)
    was, processes, memory = x.descriptors(), len(x.worlds()), x.server.memory_kb()
    for number in range(60):
        assert x.ask("back", time=now * (number % 20) // 20, branch=0)["time_ps"] == now * (number % 20) // 20
    until(lambda: len(x.worlds()) == processes)
    assert x.descriptors() == was
    assert x.server.memory_kb() - memory < 2000
    assert len(list(folder_named(x).iterdir())) == 1


def folder_named(x):
    """The folder, when the first branch is gone."""
    (world, *_) = x.worlds()
    open_files = [os.readlink(f"/proc/{world}/fd/{name}") for name in os.listdir(f"/proc/{world}/fd")]
    return next(Path(name).parent for name in open_files if Path(name).name.startswith("branch"))


def test_twenty_branches_that_were_changed_of_which_the_last_ones_are_kept(module):
    x = module()
    x.ask("pause")
    for number in range(1, 21):
        assert (
            x.ask("back", time=f"{number} us")["branch"] == number
            if number == 1
            else x.ask("back", time=f"{number} us", branch=0)
        )
        x.ask("drive", pin=f"{X}.ui1", level=0)
    found = x.ask("branches")
    assert [row["number"] for row in found["branches"]] == [0, *range(5, 21)] and found["current"] == 20
    until(lambda: len(x.worlds()) == 16)
    assert x.ask("branch", number=5)["time_ps"] == 5 * 10**6


def test_a_branch_of_a_branch_of_a_branch(module):
    x = module("--rate", "20")
    x.begin(*LONG)
    time.sleep(0.2)
    x.ask("pause")
    now = x.ask("view")["time_ps"]
    places = {}
    for number in range(1, 7):
        x.ask("back", time=now // 2 + number * 10**9)
        x.ask("drive", pin=f"{X}.ui1", level=number % 2)
        x.ask("until", time=now // 2 + (number + 2) * 10**9)
        places[number] = everything(x.ask)
    for number in (3, 1, 6, 2, 5, 4):
        x.ask("branch", number=number)
        assert differences(places[number], everything(x.ask)) == []
        x.ask("back", time=places[number]["status"]["time_ps"], branch=number)
        assert differences(places[number], everything(x.ask)) == []


def test_a_client_or_a_host_that_goes_in_the_middle(module, client):
    x = module()
    for _ in range(5):
        gone = x.another()
        gone.client.send(b'{"do": "back", "time": "1 ms", "branch": 0}\n')
        gone.client.close()
    until(lambda: x.ask("branches")["current"] != 0)
    x.host.close()
    host = client(x.server.ports[X])
    x.ask("go")
    assert host.ask(b"V1\r") == b"V+0\r"
    host.close()
    x.ask("branch", number=0)
    x.ask("go")
    assert client(x.server.ports[X]).ask(b"V1\r") == b"V+0\r"


def test_events_go_on_when_branches_change_and_stop_when_they_are_no_longer_wanted(module):
    x = module()
    x.ask("pause")
    x.ask("back", time="1 ms")
    x.ask("subscribe", every="10 ms")  # in a branch
    x.ask.client.send(b'{"do": "branch", "number": 0, "id": 1}\n')

    def next_event(kind):
        while (found := x.ask.answer()).get("event") != kind:
            pass
        return found

    assert next_event("branch")["branch"] == 0
    assert next_event("view")["view"]["pace"]["branch"] == 0  # whole
    x.ask.client.send(b'{"do": "drive", "pin": "gs_c200s.ui1", "level": 0}\n')
    assert next_event("view")["view"]["chips"][X]["levels"]["ui1"] == 0
    x.ask.client.send(b'{"do": "back", "time": "1 ms"}\n')
    next_event("branch")
    x.ask.client.send(b'{"do": "subscribe", "every": 0, "id": "end"}\n')
    while x.ask.answer().get("id") != "end":
        pass
    x.ask.client.socket.settimeout(0.3)
    with pytest.raises(socket.timeout):
        x.ask.answer()
    before = cpu_s(x.server.process.pid)
    time.sleep(0.3)
    assert cpu_s(x.server.process.pid) - before < 0.1


def cpu_s(process):
    """The time that a process has worked."""
    return sum(map(int, Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[11:13])) / os.sysconf(
        "SC_CLK_TCK"
    )


@pytest.mark.parametrize(
    ("name", "pieces", "answer"),
    [
        ("mc1451a", (b"\x90", b"\x00"), b"\x02"),
        ("cy525", (b"HEL", b"LO\r"), None),
        ("cy525", (b"?", b"\r"), b"? ready\r\n"),
    ],
)
def test_requests_that_come_in_pieces_are_whole_in_the_branch(serve, client, tmp_path, name, pieces, answer):
    """The beginning goes to the first run, the end to the branch, and the next ones the other way."""
    framing = ["--framing"] if name == "cy525" else []
    ports = ("--tcp", "127.0.0.1:0", "--control", "127.0.0.1:0", "--journal", tmp_path / "journal")
    server = serve(name, *framing, *ports, ports=2)
    ask, host = Asks(client(server.ports["control"])), client(server.ports[name])
    if name == "mc1451a":
        host.read(b"\n")
    ask("until", time="20 ms")
    first, rest = pieces
    for step in range(4):
        host.send(first)
        time.sleep(0.05)
        ask("pause")
        ask("back", time="10 ms") if not step % 2 else ask("branch", number=0)
        ask("go")
        host.send(rest)
        assert host.read(answer) == answer
