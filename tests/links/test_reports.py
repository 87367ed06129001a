"""Findings where somebody looks: on standard error, in a transcript there, once a minute each."""

from __future__ import annotations

import pytest

from slewline.core.chip import Finding
from slewline.links.reports import PERIOD_S, Reports

ONE = ("gs-c200s", "--strap", "chs=0", "--lockstep", "--tcp", "127.0.0.1:0")


class Minutes:
    """The timers of a loop, worked off by hand."""

    def __init__(self):
        self.calls = []

    def after(self, seconds, call):
        assert seconds == PERIOD_S
        self.calls.append(call)

    def pass_(self):
        calls, self.calls = self.calls, []
        for call in calls:
            call()


@pytest.fixture
def stand():
    told, minutes = [], Minutes()
    return Reports(minutes, told.append), minutes, told


def found(reports, *codes, source="x"):
    for code in codes:
        reports.found(Finding(0, source, code, "text"))


def test_each_code_of_each_source_is_told_once_a_minute_and_the_others_are_counted(stand):
    reports, minutes, told = stand
    found(reports, "E1", "E1", "E2", "E1")
    found(reports, "E1", source="y")
    assert told == ["x: E1: text", "x: E2: text", "y: E1: text"]
    minutes.pass_()
    assert told[3:] == ["x: E1: 2 more like this: text"]
    found(reports, "E1", "E2")
    assert told[4:] == ["x: E2: text"]
    minutes.pass_()
    assert told[5:] == ["x: E1: 1 more like this: text"]
    for _ in range(2):
        minutes.pass_()
    assert told[6:] == [] and reports.more == {} and minutes.calls == []
    found(reports, "E1")
    assert told[6:] == ["x: E1: text"]


def test_what_is_left_is_told_at_the_end(stand):
    reports, _, told = stand
    found(reports, "E1", "E1", "E2")
    reports.close()
    assert told == ["x: E1: text", "x: E2: text", "x: E1: 1 more of these"]


def test_the_command_tells_findings_on_standard_error(serve, client):
    server = serve(*ONE)
    host = client(server.where)
    for _ in range(3):
        assert host.ask(b"HELLO\r") == b"E2\r"
    first = server.errors()
    assert first.startswith("slewline: gs_c200s: E2: ") and "HELLO" in first
    assert server.end() == (0, "slewline: gs_c200s: E2: 2 more of these\n")


def test_a_transcript_on_standard_error_has_the_findings_and_nobody_tells_them_twice(serve, client):
    server = serve(*ONE, "--log", "-")
    host = client(server.where)
    assert host.ask(b"HELLO\r") == b"E2\r"
    host.close()
    status, shown = server.end()
    lines = [line.split(maxsplit=1)[1] for line in shown.splitlines()]
    assert status == 0
    assert next(line for line in lines if "HELLO" in line) == r"gs_c200s < HELLO\r"
    assert len([line for line in lines if "E2: " in line]) == 1
    assert r"gs_c200s > E2\r" in lines
    assert "slewline:" not in shown
