"""Words on a command line that are in each other's place: every command recognises them, and writes the line."""

from __future__ import annotations

import shlex
from itertools import permutations
from pathlib import Path

import click
import pytest

from slewline.cli.commands import cli
from slewline.cli.options.word_order import ANY, FILES, TAKES, kind_of, misplaced
from tests.rows import rows

SAMPLE = {  # of each kind
    "chip": "gs-c200s",
    "port": "/dev/ttyUSB0",
    "address": "127.0.0.1:4001",
    "file": "prog.gs-c200s",
    "recording": "measured.csv",
    "bench file": "bench.toml",
    "parameter": "S=10",
    "motor": "QSH4218-51-10-049",
    ANY: "frobnicate",
}
WRONG = [  # what was typed, and the line that is meant
    ("push gs-c200s prog.gsc", "push PORT prog.gsc --chip gs-c200s"),
    ("push prog.gsc /dev/ttyUSB0 --store", "push /dev/ttyUSB0 prog.gsc --store"),
    ("pull gs-c200s /dev/ttyUSB0", "pull /dev/ttyUSB0 --chip gs-c200s --output F"),
    ("pull gs-c200s /dev/ttyUSB0 -o a", "pull /dev/ttyUSB0 --chip gs-c200s -o a"),
    ("pull saved.gs-c200s COM3", "pull COM3 --output saved.gs-c200s"),
    ("run cy525 p.cy525", "run p.cy525 --chip cy525"),
    ("run cy525 p.cy525 --until '2 s'", "run p.cy525 --chip cy525 --until '2 s'"),
    ("run cy525", "run FILE --chip cy525"),
    ("asm cy525 p.cy525", "asm p.cy525 --chip cy525"),
    ("dis cy525 p.hex", "dis p.hex --chip cy525"),
    ("lint cy525 p.cy525 q.cy525", "lint p.cy525 q.cy525 --chip cy525"),
    ("drive p.cy525 --board twin --tcp 4001", "drive cy525 --board twin --tcp 4001"),
    ("tune p.cy525", "tune cy525 --motor MOTOR --driver TEXT --steps N"),
    ("tune QSH4218-51-10-049 cy525 --driver x --steps 5", "tune cy525 --motor QSH4218-51-10-049 --driver x --steps 5"),
    ("ramp S=10 gs-c200s", "ramp gs-c200s S=10"),
    ("ramp p.cy525 R=100", "ramp cy525 R=100"),
    ("describe GO cy525", "describe cy525 GO"),
    ("describe p.cy525 G", "describe cy525 G"),
    ("compare measured.csv model.vcd", "compare model.vcd measured.csv"),
    ("compare /dev/ttyUSB0 x.dialogue", "compare x.dialogue --port /dev/ttyUSB0"),
    ("terminal gs-c200s /dev/ttyUSB0", "terminal /dev/ttyUSB0 --chip gs-c200s"),
    (
        "epics S=10 /dev/ttyUSB0 T=9 --chip gs-c200s --record x",
        "epics /dev/ttyUSB0 S=10 T=9 --chip gs-c200s --record x",
    ),
    ("proxy /dev/ttyUSB0 --chip gs-c200s --dialogue f", "proxy --serial /dev/ttyUSB0 --chip gs-c200s --dialogue f"),
    ("check-capture cy525 a.csv --axis x=a,b", "check-capture a.csv --chip cy525 --axis x=a,b"),
    ("calibrate QSH4218-51-10-049 --driver x", "calibrate --motor QSH4218-51-10-049 --driver x"),
    ("serve /dev/ttyUSB0 gs-c200s", "serve gs-c200s --serial /dev/ttyUSB0"),
    ("serve gs-c200s 4001", "serve gs-c200s --tcp 4001"),
    ("serve b.toml --tcp 4001", "serve --bench b.toml --tcp 4001"),
    ("drive gs-c200s /dev/ttyACM0 --tcp 4001", "drive gs-c200s --board /dev/ttyACM0 --tcp 4001"),
    ("panel cy525 p.cy525", "panel p.cy525 --chip cy525"),
    ("panel 127.0.0.1:4001", "panel --attach 127.0.0.1:4001"),
    ("debug cy525 p.cy525", "debug p.cy525 --chip cy525"),
]
RIGHT = [
    "run p.cy525 --chip cy525",
    "run - --chip cy525",
    "run /dev/stdin --chip cy525",
    "run p.txt --drive abort=0@1ms --strap wait=1",
    "push module prog.gsc",
    "pull socket://127.0.0.1:4001 -o a.gs-c200s",
    "serve my_lab.mx10:Mx10 --tcp 4001",
    "ramp cy525 F",
    "describe cy525 4001",
    "run --part cy525 p.cy525",  # an option that is not there has its own message
    "serve cy525 --port 4001",
    "terminal --part gs-c200s module",
    "run a.cy525 b.cy525",  # no option takes a second file
    "examples cy525",
    "run p.cy525 --json --drive abort=0",
    "run p.cy525 --vcd - --chip cy525",
    "new-chip cy525",
]


def says(line: str) -> str | None:
    """What is said of a line."""
    name, *words = shlex.split(line)
    command = cli.commands[name]
    return misplaced(command, click.Context(command, info_name=name), words)


@rows(("line", "meant"), WRONG)
def test_the_line_that_was_meant_is_written(line, meant, call):
    ran = call(*shlex.split(line))
    assert ran.status == 2 and ran.err.endswith(f"; write:  slewline {meant}\n")
    assert says(meant) is None


@rows("line", RIGHT)
def test_a_line_in_order_is_left_alone(line):
    assert says(line) is None


def test_every_command_recognises_words_that_are_exchanged():
    told, replaced = 0, {SAMPLE[kind] for kind in FILES}  # a file in the place of a chip
    for name, command in cli.commands.items():
        arguments = [each for each in command.params if isinstance(each, click.Argument)]
        for words in permutations(SAMPLE.values(), min(2, len(arguments))):
            found = says(shlex.join([name, *words]))
            if found is not None:
                told += 1
                line = found.partition("write:  slewline ")[2]
                assert line.startswith(f"{name} ") and says(line) is None, (name, words, found)
                assert all(word in line or word in replaced for word in words), (words, line)
    assert told > 100


def test_every_argument_with_a_kind_is_known():
    kinds = {
        each.name for command in cli.commands.values() for each in command.params if isinstance(each, click.Argument)
    }
    assert set(TAKES) <= kinds
    assert kinds - set(TAKES) == {"command", "name"}  # of which any word may be one


@pytest.mark.parametrize("kind", SAMPLE)
def test_a_word_is_of_its_kind(kind):
    assert kind_of(cli.commands["tune"], SAMPLE[kind]) == kind


def test_a_file_that_exists_may_be_called_like_a_chip_or_a_parameter(folder):
    for name in ("cy525", "S=10", "4001"):
        Path(name).write_text("A 0\n")
        assert kind_of(cli.commands["run"], name) in (ANY, *FILES)
    assert says("run cy525 --chip cy525") is None


@pytest.mark.posix
@pytest.mark.system
def test_the_link_of_a_pseudo_terminal_is_a_port(folder):
    import os

    ours, theirs = os.openpty()
    try:
        Path("module").symlink_to(os.ttyname(theirs))
        assert kind_of(cli.commands["push"], "module") == "port"
        assert "write:  slewline push module prog.gsc" in str(says("push prog.gsc module"))
    finally:
        os.close(ours)
        os.close(theirs)
