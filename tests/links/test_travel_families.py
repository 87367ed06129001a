"""The way back, for every family of chips: each instant is as it was, and nothing outside notices the branches."""

from __future__ import annotations

import os
import random
import time
from dataclasses import dataclass

import pytest

from slewline.links.clients.chipset_host import ChipsetHost

from .conftest import Asks, until

pytestmark = [
    pytest.mark.system,
    pytest.mark.skipif(not hasattr(os, "fork"), reason="the system cannot copy a process"),
]

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


@pytest.mark.parametrize(("name", "pace"), [*zip(FAMILIES, PACES * 2, strict=True)])
def test_every_instant_is_as_it_was(begin, name, pace):
    session = begin(name, 1, *pace)
    seen = session.play(acts=18, looks=3)
    assert len({repr(one["levels"]) for one in seen}) > 1
    compare(session, seen)


@pytest.mark.long
@pytest.mark.parametrize("seed", range(2, 6))
@pytest.mark.parametrize("pace", [*PACES, ("--rate", "0.05"), ("--rate", "1000")], ids="".join)
@pytest.mark.parametrize("name", FAMILIES)
def test_every_instant_of_longer_sessions_is_as_it_was(begin, name, pace, seed):
    session = begin(name, seed, *pace)
    compare(session, session.play(acts=150, looks=25))
