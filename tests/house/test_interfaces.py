"""The interfaces of users are those that they were: a name that goes, or changes its arguments, is listed here."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.house import interfaces

KEPT = Path(__file__).with_name("interfaces.txt")
CHANGED: dict[str, str] = {}  # a kept line, and the one that has taken its place, or the reason why none has

pytestmark = pytest.mark.check


def test_kept_interfaces_exist() -> None:
    present = {*interfaces.present()}
    missing = [line for line in KEPT.read_text("utf-8").splitlines() if line not in present and line not in CHANGED]
    assert not missing, "list each in CHANGED with its successor, and in the changelog"


def test_each_kind_of_interface_is_kept() -> None:
    lines = KEPT.read_text("utf-8").splitlines()
    kinds = ("api", "attribute", "bench file", "code", "command", "control", "option")
    assert all(sum(line.startswith(kind) for line in lines) >= 40 for kind in kinds)


def test_a_lost_argument_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    import slewline

    monkeypatch.setattr(slewline, "replay", lambda journal: None)
    assert {line for line in interfaces.api() if line.startswith("api slewline.replay")} == {
        "api slewline.replay(journal)"
    }
    assert "api slewline.replay(journal)" not in KEPT.read_text("utf-8").splitlines()
