"""The interfaces of users are those that they were: a name that goes, or changes its arguments, is listed here."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import slewline
import slewline.build
from tests.house import interfaces

KEPT = Path(__file__).with_name("interfaces.txt")
RENAMED = {"says": "description", "way": "in_out", "told": "transcript"}  # arguments; the former names still work
CHANGED = {  # a kept line of a provisional class, and its successor
    "attribute Module.notice(text)": "attribute Module.report_once(text)",
    "attribute Module.say": "attribute Module.report",
    "attribute Server.tell": "attribute Server.report",
}

pytestmark = pytest.mark.check


def test_kept_interfaces_exist() -> None:
    present = {*interfaces.present()}
    kept = (CHANGED.get(line, line) for line in KEPT.read_text("utf-8").splitlines())
    missing = [line for line in kept if line not in present and renamed(line) not in present]
    assert not missing, "list each in CHANGED with its successor, and in the changelog"


def renamed(line: str) -> str:
    """Return a line with the present names of its arguments."""
    name, _, arguments = line.partition("(")
    former = "|".join(rf"(?<![a-z_]){each}(?![a-z_])" for each in RENAMED)
    return f"{name}({re.sub(former, lambda found: RENAMED[found[0]], arguments)}"


def test_former_names_of_arguments_still_work() -> None:
    pin = slewline.build.Pin(number=1, name="step", way="out", says="steps")  # type: ignore[call-arg]
    assert (pin.in_out, pin.description) == ("out", "steps")
    assert (pin.way, pin.says) == ("out", "steps")  # type: ignore[attr-defined]


def test_each_kind_of_interface_is_kept() -> None:
    lines = KEPT.read_text("utf-8").splitlines()
    kinds = ("api", "attribute", "bench file", "code", "command", "control", "option")
    assert all(sum(line.startswith(kind) for line in lines) >= 40 for kind in kinds)


def test_a_lost_argument_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(slewline, "replay", lambda journal: None)
    assert {line for line in interfaces.api() if line.startswith("api slewline.replay")} == {
        "api slewline.replay(journal)"
    }
    assert "api slewline.replay(journal)" not in KEPT.read_text("utf-8").splitlines()
