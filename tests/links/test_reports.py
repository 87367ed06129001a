"""Findings where somebody looks: on standard error, in a transcript there, once a minute each."""

from __future__ import annotations

import pytest

import slewline
from slewline.core.component import Finding
from slewline.links.lines.pace import Lag, Paced
from slewline.links.server import Server
from slewline.links.views.reports import CAUSES, PERIOD_S, FindingReports, Lateness, cause_of

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
    return FindingReports(minutes, told.append), minutes, told


def found(reports, *codes, source="x"):
    for code in codes:
        reports.found(Finding(0, source, code, "text"))


def test_each_code_of_each_source_is_reported_once_a_minute_and_the_others_are_counted(stand):
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


def test_the_rest_is_reported_at_the_end(stand):
    reports, _, told = stand
    found(reports, "E1", "E1", "E2")
    reports.close()
    assert told == ["x: E1: text", "x: E2: text", "x: E1: 1 more like this: text"]


def said(reports, *texts, code="E4"):
    for text in texts:
        reports.found(Finding(0, "x", code, text))


def test_two_causes_of_a_code_do_not_hide_each_other(stand):
    reports, minutes, told = stand
    case = "{!r} is not a command of the gs-c200s; write {}: no spaces, and case matters"
    said(reports, case.format("v1", "V1"), case.format("po", "Po"), "+100 outside a program; begin with Po")
    assert [text.partition("; ")[2][:10] for text in told] == ["write V1: ", "write Po: ", "begin with"]
    said(
        reports, case.format("v1", "V1"), "+20 outside a program; begin with Po", "+3 outside a program; begin with Po"
    )
    assert len(told) == 3
    minutes.pass_()
    assert told[3:] == [
        "x: E4: 1 more like this: 'v1' is not a command of the gs-c200s",
        "x: E4: 2 more like this: ... outside a program",
    ]


def test_repeated_texts_are_shown_as_far_as_they_agree_and_cut_between_words(stand):
    reports, minutes, told = stand
    case = "a line begins with {!r}, which is not the address of a module here: no module answers; begin the line with"
    said(reports, case.format("V"), case.format("*"))
    minutes.pass_()
    assert told[1:] == [
        "x: E4: 1 more like this: a line begins with ..., which is not the address of a module here: no module ..."
    ]


@pytest.mark.parametrize(
    ("one", "two"),
    [
        ("b'V1': checksum '1' (0x31), expected 'V' (0x56)", r"b'\'x\\': checksum ')' (0x29), expected 'Q' (0x51)"),
        ("S5000: speed 5000, allowed 1..1000", "S0: speed 0, allowed 1..1000"),
        ("a count of -3", "a count of 17"),
    ],
)
def test_numbers_and_host_text_do_not_change_the_cause(one, two):
    assert cause_of(Finding(0, "x", "E1", one)) == cause_of(Finding(9, "x", "E1", two))


def test_a_flood_of_causes_is_counted_after_the_first_ones(stand):
    reports, minutes, told = stand
    said(reports, *(f"cause {'abcdefghijklmnopqrst'[n] * 3}" for n in range(20)))
    said(reports, "of its own", code="E1")
    assert len(told) == CAUSES + 1
    minutes.pass_()
    assert told[CAUSES + 1 :] == [f"x: E4: {20 - CAUSES} more with other causes"]


# -------------------------------------------------------------------------------------------------- behind the clock
def test_a_lag_is_reported_when_it_begins_and_when_it_ends():
    told, lag = [], Lag()
    lateness = Lateness(lag, 1, told.append)
    lateness.check()
    assert told == []
    lag.lost_ns += 2_000_000_000
    lateness.check()
    (first,) = told
    assert first.startswith("virtual time lags behind the wall clock (2.0 s lost so far): ")
    assert first.endswith("is too slow, or too busy, for --rate 1; give a lower rate, or --lockstep")
    for lost in (1_500_000_000, 0, 1_000_000_000, 0, 0):  # a check without a loss is not the end
        lag.lost_ns += lost
        lateness.check()
    assert told[1:] == ["virtual time follows the wall clock again; 4.5 s lost"]
    lateness.check()
    lateness.close()
    assert len(told) == 2
    lag.lost_ns += 10**9
    lateness.close()
    assert told[3:] == ["virtual time lagged until the end; 1.0 s lost"]


def test_a_server_that_lags_reports_it_on_the_terminal_and_in_the_transcript(tmp_path):
    told, bench = [], slewline.Bench()
    bench.add("gs-c200s")
    server = Server(bench, Paced(bench), tmp_path / "log", report=told.append)
    server.pace.lag.lost_ns = 3_000_000_000
    server._look_around()
    server.close()
    assert [text.partition(" (")[0] for text in told] == [
        "virtual time lags behind the wall clock",
        "virtual time lagged until the end; 3.0 s lost",
    ]
    assert "server ! virtual time lags behind the wall clock" in (tmp_path / "log").read_text()


@pytest.mark.system
def test_the_command_reports_findings_on_standard_error(serve, client):
    server = serve(*ONE)
    host = client(server.where)
    for _ in range(3):
        assert host.ask(b"HELLO\r") == b"E2\r"
    first = server.errors()
    assert first.startswith("slewline: gs_c200s: E2: ") and "HELLO" in first
    assert server.end() == (
        0,
        "slewline: gs_c200s: E2: 2 more like this: 'HELLO' does not fit H[<+/->]\n",
    )


@pytest.mark.system
def test_a_transcript_on_standard_error_has_the_findings_only_once(serve, client):
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
