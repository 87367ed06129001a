"""pull and push on served modules of four kinds: a kill, and a cut cable, at any instant.

Nothing of the user's is lost or half-written, M comes only after the listing has agreed, and no step is made.
"""

from __future__ import annotations

import json
import subprocess
import sys
import time
from pathlib import Path
from random import Random

import pytest

from slewline.chips import sheet_of
from slewline.cli.main import invoke
from slewline.language.assemble import assemble
from slewline.modules import finding, spoken

from ..links.conftest import PATIENCE, Asks, Client, Process

LOOK_S = 5.0  # for a module that answers every line: its server may be kept from running for a while
PATIENT = f"""
from slewline.modules import finding, spoken
finding.LOOK_S, spoken.ANSWER_S = {LOOK_S}, {PATIENCE}
"""
MAIN = "from slewline.cli.main import main; main()"
OLD = {"gs": ["S11", "T99", "R9", "-5"], "cy": ["R 11", "F 9", "G"]}
NEW = {
    "gs": ["S10", "T100", "R40", "W1", "+250", "L0", "A2", "D1", "C2", "W2", "+120", "L4"],
    "cy": ["R 100", "N 17", "G", "P 300", "+", "G", '"Quit?"', "R 5"],
}
THREE = "".join(
    f"""[[chip]]
part = "gs-c200"
name = "x{address}"
straps = {{ br0 = 0, br1 = 0, br2 = 0, chs = 1, sel0 = {sel0}, sel1 = {sel1}, sel2 = {sel2} }}
"""
    for address, (sel2, sel1, sel0) in ((1, (0, 1, 1)), (2, (1, 0, 1)), (3, (0, 0, 1)))
)


class Served:
    """A module of a kind on a port of loopback, ten times as fast as a real one."""

    def __init__(self, kind, folder):
        self.kind, self.folder = kind, folder
        self.part = "gs-c200" if kind == "three" else kind
        self.family = self.part[:2]
        self.options = ["--address", "2"] if kind == "three" else []
        self.start()

    def start(self):
        folder, rest = self.folder, ["--control", "127.0.0.1:0", "--rate", "10"]
        if self.kind == "three":
            (folder / "three.toml").write_text(
                f'{THREE}[[serve]]\nchips = ["x1", "x2", "x3"]\ntcp = "127.0.0.1:0"\n', "utf-8"
            )
            how = ("--bench", folder / "three.toml", "--state", folder / "kept")
        else:
            (folder / "image").write_bytes(b"0\r")
            more = ["--strap", "chs=0", "--state", folder / "kept"]
            if self.family == "cy":
                new = not (folder / "kept").exists()
                more = (["--memory", folder / "image"] if new or self.kind == "cy545" else []) + (
                    ["--state", folder / "kept"] if self.kind == "cy545b" else []
                )
            how = (self.part, "--tcp", "127.0.0.1:0", *more)
        self.server = Process(*how, *rest, ports=2, folder=folder)
        self.port = self.server.where
        self.client = Client(self.server.ports["control"])
        self.control = Asks(self.client)

    @property
    def steps(self):
        return sum(chip["steps"] for chip in self.control("status")["chips"].values())

    def write(self, path, lines):
        sheet = sheet_of(self.part)
        end = [] if sheet.leave[-1].may_step else [sheet.leave[-1].form]
        stop = ["0"] if self.family == "cy" else []
        Path(path).write_text("".join(f"{line}\n" for line in (sheet.enter.form, *lines, *stop, *end)), "utf-8")

    def words(self, what, *more):
        store = ["--store"] if what == "push" and self.family == "gs" else []
        return [what, self.port, *self.options, "--part", self.part, *store, *more]

    def call(self, what, *more):
        return invoke(self.words(what, *more))

    def pushing(self):
        """Push in a process of its own; return it when it has found the module."""
        code = (PATIENT if self.family == "gs" else "") + MAIN
        process = subprocess.Popen(
            [sys.executable, "-c", code, *self.words("push", "new")], stderr=subprocess.PIPE, text=True
        )
        process.stderr.readline()
        return process

    def stored(self, path):
        return assemble(Path(path).read_text("utf-8"), sheet_of(self.part), path).stored

    def end(self):
        self.client.close()
        self.server.over()


pytestmark = [
    pytest.mark.system,
    pytest.mark.timeout(600),  # what comes damaged to a server that stands now and then is written again
]
KINDS = ("gs-c200s", "three", "cy545", "cy545b")


def often(number, *quick):
    """Every kind so many times; of these kinds once in a quick run."""
    return [
        pytest.param(kind, seed, marks=[] if not seed and kind in quick else [pytest.mark.long])
        for kind in KINDS
        for seed in range(number)
    ]


@pytest.fixture(params=KINDS)
def served(request, tmp_path, monkeypatch):
    """A module that holds a program, OLD, which it keeps without power if it can; NEW is to be sent."""
    monkeypatch.chdir(tmp_path)
    module = Served(request.param, tmp_path)
    if module.family == "gs":  # a CY545 says nothing to most of its lines, so nobody waits long for an answer of it
        monkeypatch.setattr(finding, "LOOK_S", LOOK_S)
        monkeypatch.setattr(spoken, "ANSWER_S", PATIENCE)
    module.write("old", OLD[module.family])
    module.write("new", NEW[module.family])
    assert module.call("push", "old") == 0
    yield module
    module.end()


def check_files(served):
    """What the user has is whole: programs that he has written, and those that were saved."""
    for path in served.folder.glob("*before*"):
        if not path.name.endswith(".dialogue"):
            assert served.stored(path) is not None, path
    assert served.stored("new") != served.stored("old")
    for path in served.folder.glob("*.dialogue"):
        lines = path.read_bytes().split(b"\n")
        assert [json.loads(line) for line in lines[:-1]], path


def saved(served):
    """What was in the module before, as it was saved beside the file."""
    paths = [path for path in served.folder.glob("new.before*") if not path.name.endswith(".dialogue")]
    return [served.stored(path) for path in paths]


@pytest.mark.parametrize(("served", "_seed"), often(1, "three", "cy545b"), indirect=["served"])
def test_a_program_goes_in_and_comes_out_without_a_step(served, _seed, capfd):
    assert served.call("push", "new") == 0
    assert served.call("pull", "-o", "out") == 0
    assert served.stored("out") == served.stored("new")
    assert saved(served) == [served.stored("old")]
    assert served.steps == 0
    check_files(served)
    if served.family == "gs":
        assert served.call("pull", "-o", "both", "--eeprom") == 0
        assert served.stored("both") == served.stored("both.eeprom") == served.stored("new")


@pytest.mark.parametrize(("served", "seed"), often(50, "cy545b"), indirect=["served"])
def test_a_push_that_is_killed_loses_nothing_and_the_next_one_resumes(served, seed, capfd):
    random = Random(f"{served.kind} {seed}")
    pushing = served.pushing()
    time.sleep(random.uniform(0, 1.5 if served.family == "gs" else 4))
    pushing.kill()
    pushing.communicate()
    check_files(served)
    assert served.call("push", "new") == 0
    assert served.call("pull", "-o", "out") == 0
    assert served.stored("out") == served.stored("new")
    assert served.stored("old") in saved(served)
    assert served.steps == 0
    check_files(served)


@pytest.mark.parametrize(("served", "seed"), often(10, "three"), indirect=["served"])
def test_a_cut_cable_is_reported_with_the_content_of_the_module(served, seed, capfd):
    pushing = served.pushing()
    time.sleep(Random(f"{served.kind} {seed}").uniform(0, 1 if served.family == "gs" else 2))
    assert served.steps == 0
    served.end()
    _, told = pushing.communicate(timeout=60)
    check_files(served)
    assert pushing.returncode in (0, 1), told
    if pushing.returncode:
        assert "the port is gone" in told
        assert not saved(served) or ", as far as its answers show: " in told
    served.start()
    if (
        served.family == "gs"
        and saved(served)
        and "it is unknown whether it was stored" not in told
        and pushing.returncode
    ):
        assert served.call("pull", "-o", "after", "--eeprom") == 0  # switched off: RAM is empty, the EEPROM as it was
        assert served.stored("after.eeprom") == served.stored("old")
    assert served.call("push", "new") == 0
    assert served.call("pull", "-o", "out") == 0
    assert served.stored("out") == served.stored("new")
    assert served.steps == 0
