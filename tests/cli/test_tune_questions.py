"""tune in a terminal asks for what is missing: a list, a default, and at the end the line to type the next time."""

from __future__ import annotations

import shlex
import subprocess
import sys
from time import monotonic

import click
import pytest

from slewline.cli.commands import cli
from slewline.cli.motors import wizard
from slewline.cli.motors.wizard import Question, chip_question, driver_question, load_question, motor_question
from tests.terminals import Terminal

MOTOR = {"motor": "QSH4218-51-10-049"}
LATE_S = 60.0
QUICK = "F=6 R=13 S=199"


class Dialogue:
    """A command on a terminal, and what it has written there."""

    def __init__(self, *words: str, output: int | None = None) -> None:
        self.terminal = Terminal([sys.executable, "-m", "slewline", *words], output)
        self._begin = 0

    @property
    def said(self) -> str:
        """All that it has written."""
        return self.terminal.seen.decode().replace("\r\n", "\n")

    def answer(self, question: str, text: str) -> None:
        """Type a text after a question that was not there before."""
        late = monotonic() + LATE_S
        while question not in self.said[self._begin :]:
            assert monotonic() < late and self.terminal.status is None, self.said
            self.terminal.looks(1)
        self._begin = len(self.said)
        self.terminal.types(text)

    def ended(self, key: str = "") -> int:
        """Read the rest, and press a key each second; return the exit status."""
        late = monotonic() + LATE_S
        while self.terminal.status is None:
            assert monotonic() < late, self.said
            if not self.terminal.looks(1):
                self.terminal.types(key)
        self.terminal.close()
        return self.terminal.status


@pytest.mark.system
@pytest.mark.posix
def test_the_questions_and_the_line_that_stands_for_them():
    terminal = Dialogue("tune", "--grid", QUICK, "--no-switching")
    terminal.answer("Chip [cy525]: ", "\n")
    terminal.answer("Motor [QSH4218-51-10-049]: ", "17hs\n")
    terminal.answer("Motor [17HS4401]: ", "2\n")
    terminal.answer("Driver [24 V, 2 A averaged]: ", "24 volt\n")
    terminal.answer("Driver [24 V, 2 A averaged]: ", "L/4R 20 V\n")
    terminal.answer("Load [none]: ", "inertia 20 g cm2\n")
    terminal.answer("Steps of the move, from rest to rest [500]: ", "0\n")
    terminal.answer("Steps of the move, from rest to rest [500]: ", "40\n")
    status = terminal.ended()
    assert "'24 volt' is not recognised" in terminal.said and "1 or more" in terminal.said
    line = terminal.said.partition("The same without questions:\n")[2].splitlines()[0]
    assert shlex.split(line) == [
        *("slewline", "tune", "cy525", "--grid", QUICK, "--no-switching", "--motor", "17HS19-2004S1"),
        *("--driver", "L/4R 20 V", "--load", "inertia 20 g cm2", "--steps", "40"),
    ]
    assert status == 0 and "recommended" in terminal.said.partition("without questions")[2]
    again = subprocess.run([sys.executable, "-m", *shlex.split(line)], capture_output=True, text=True, check=False)
    assert again.returncode == 0 and again.stdout.splitlines()[-1] in terminal.said


@pytest.mark.system
@pytest.mark.posix
def test_ctrl_c_and_ctrl_d_end_it(tmp_path):
    for key in ("\x03", "\x04"):
        with (tmp_path / "out").open("wb") as out:
            terminal = Dialogue("tune", "cy525", "--steps", "40", "--json", output=out.fileno())
        terminal.answer("Motor [QSH4218-51-10-049]: ", key)
        assert terminal.ended(key) == 1  # Python sees no signal that comes just before it waits for a line
        assert terminal.said.endswith("\nslewline: interrupted; unfinished files are unchanged\n")
        assert (tmp_path / "out").read_bytes() == b"" and "Chip" not in terminal.said


@pytest.mark.system
@pytest.mark.posix
def test_a_complete_line_is_not_prompted_for():
    terminal = Dialogue(
        *("tune", "cy525", "--motor", MOTOR["motor"], "--driver", "L/4R 20 V", "--steps", "40", "--grid", QUICK),
        "--no-switching",
    )
    assert (
        terminal.ended() == 0 and "[" + MOTOR["motor"] not in terminal.said and "without questions" not in terminal.said
    )


def test_without_a_terminal_all_that_is_missing_is_named(call):
    ran = call("tune", "cy525", "--steps", "40")
    assert ran.status == 2 and "Missing --motor, --driver; for example:  slewline tune cy525" in ran.err
    assert "Missing argument 'CHIP'" in call("tune").err


def asked(monkeypatch, question: Question, *answers: str) -> str:
    """What a question comes to, with these answers."""
    left = [*answers]
    monkeypatch.setattr(click, "prompt", lambda *_, default, **__: left.pop(0) or default)
    found = question.ask()
    assert not left
    return found


@pytest.mark.parametrize(
    ("answers", "found"),
    [
        (("",), "QSH4218-51-10-049"),
        (("3",), "QSH4218-51-10-049"),
        (("qsh4218-35-10-027",), "QSH4218-35-10-027"),
        (("1124090",), "1124090"),  # a name of digits
        (("99", "1"), "QSH4218-35-10-027"),
        (("as10", "4"), "AS1060"),
        (("17", "1"), "17HS4401"),  # number 17 was not shown
        (("as10", ""), "AS1010"),
        (("nothing like it", "as10", "2"), "AS1030"),
    ],
)
def test_an_answer_is_a_number_a_name_or_a_part_of_names(monkeypatch, answers, found):
    assert asked(monkeypatch, motor_question({}), *answers) == found


def test_a_custom_text_passes_through_the_option(monkeypatch):
    """Whatever the option takes, the question takes too."""
    question = motor_question({})
    question.check = lambda text: None if text.startswith("current 2 A") else motor_question({}).check(text)
    assert asked(monkeypatch, question, "current 2 A, resistance 1 ohm") == "current 2 A, resistance 1 ohm"


DRIVEN = MOTOR | {"driver": "24 V, 1 A averaged"}


def test_a_load_that_the_motor_cannot_turn_is_prompted_again(monkeypatch, capsys):
    assert asked(monkeypatch, load_question(DRIVEN), "friction 5 Nm", "friction 5 mNm") == "friction 5 mNm"
    assert "5 of friction" in capsys.readouterr().err


def test_every_answer_that_is_offered_is_a_good_one():
    for question in (chip_question({}), motor_question({}), driver_question(MOTOR), load_question(DRIVEN)):
        for name, _ in [*question.choices, (question.default, "")]:
            question.check(name)


def test_the_questions_are_those_of_the_options():
    names = {each.name for each in cli.commands["tune"].params}
    asked = [name for name, _ in wizard.AskingCommand("tune").questions()]
    assert set(asked) <= names
    assert {each.name for each in cli.commands["tune"].params if each.required} <= set(asked)
