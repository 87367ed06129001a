"""The far end of a serial line: what a host is told of it, how often, and that a journal repeats it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import slewline
from slewline.language.lint import lint
from tests.rows import rows

SLOW = {"br0": 0, "br1": 1, "br2": 0, "chs": 0}  # 2400 baud


def stand(journal: Any = None, part: str = "gs-c200s", **straps: int) -> tuple[Any, Any, Any]:
    bench = slewline.Bench(journal=journal)
    x = bench.add(part, straps=SLOW | straps)
    return bench, x, bench.host(x)


def test_the_first_characters_go_out_at_the_strapped_rate():
    bench, _, host = stand()
    bench.record("gs_c200s.rxd")
    host.write(b"F\r")
    bench.run("50 ms")
    times, _ = bench.edges("gs_c200s.rxd")
    bit = 10**12 / 2400
    assert np.abs(np.diff(times) / bit - np.rint(np.diff(times) / bit)).max() < 1e-3
    assert np.diff(times).min() == pytest.approx(bit, rel=1e-3)
    assert bytes(host.received) == b"R\r" and bench.findings == []


def test_a_host_follows_what_a_module_has_made_of_its_straps():
    bench, x, host = stand()
    assert host.ask("F") == "R"
    x.pin("br0").drive(1)  # 1200 baud, as soon as the module looks again
    assert host.ask("F") == "R"
    x.power(False)
    x.power(True)
    assert host.ask("F") == "R" and host.baud == 1200
    assert bench.findings == []


@pytest.mark.parametrize("verb", ["write", "send"])
def test_a_journal_repeats_the_reports_to_the_bit(tmp_path, verb):
    path = tmp_path / "run.jsonl"
    bench, _, host = stand(path)
    getattr(host, verb)("F\rV1")
    bench.run_until_idle()
    host.send("\r")
    bench.run_until_idle()
    host.send("V1")
    bench.run_until_idle()
    host.change_line(4800, 7, "odd", 2)
    host.opened_at(300)
    host.send("F\r")
    bench.run("1 s")
    assert sorted(found.code for found in bench.findings)[:4] == ["format", "format", "unfinished", "unfinished"]
    again = slewline.replay(path)
    assert again.findings == bench.findings
    assert bytes(again.parts["host"].received) == bytes(host.received)


def test_each_pair_of_settings_is_reported_once():
    bench, _, host = stand()
    for baud in (4800, 2400, 4800, 9600, 4800):
        host.change_line(baud, 7, "odd", 2)
        for _ in range(20):
            host.write(b"\r")
        bench.run("1 s")
    told = [found.text for found in bench.findings if found.code == "format"]
    assert [text[:19] for text in told] == ["host is set to 4800", "host is set to 9600"]
    assert "or the part to 4800 baud with br0=1, br1=0, br2=0" in told[0]


def test_an_endless_line_is_reported_once_however_it_grows_and_again_when_it_is_another_one():
    bench, x, host = stand()
    for piece, count in (("V", 1), ("1", 1), ("\r", 1), ("F", 2), ("\r", 2)):
        host.send(piece)
        bench.run_until_idle()
        assert [found.code for found in x.findings] == ["unfinished"] * count


def test_a_string_of_a_cy545_lacks_its_quotation_mark():
    bench = slewline.Bench()
    x = bench.add("cy545")
    bench.host(x, over="serial").send('"abc\r')
    bench.run_until_idle()
    (found,) = [found for found in x.findings if found.code == "unfinished"]
    assert found.text.endswith("send the quotation mark that ends it")


def test_addresses_of_the_modules_on_a_line_are_reported_for_a_line_with_another_one():
    bench = slewline.Bench()
    straps = SLOW | {"br1": 0}
    left = bench.add("gs-c200s", "left", straps=straps | {"sel0": 0})
    right = bench.add("gs-c200s", "right", straps=straps | {"sel1": 0})
    host = bench.host(left, right)
    host.send("4F\r2F\r\n4F\r")
    bench.run("100 ms")
    assert bench.findings == [found for found in bench.findings if found.code == "line-end"]
    host.send("5F\rF\r5V1\r")
    bench.run("100 ms")
    told = [found.text for found in host.findings]
    assert [text[:24] for text in told] == ["a line begins with '5', ", "a line begins with 'F', "]
    assert all("begin the line with 2 (right), 4 (left)" in text for text in told)


def test_a_read_without_answer_reports_that_nothing_can_come():
    bench = slewline.Bench()
    port = bench.part("serial_port", name="port")
    assert "nothing drives its rxd" in port.got(b"R").text
    _, _, host = stand()
    assert "nothing drives" not in host.got(b"R").text


@rows("line", ["v1", "S 10", "+100", "S10", "Lo9", "R5000", "V3", "4V1", "A3t", "f 5", "Px 1"])
@rows("part", ["gs-c200", "gs-c200s"])
def test_a_finding_in_a_run_gives_the_advice_of_the_linter(part, line):
    bench, x, host = stand(part=part)
    answer = host.ask(line)
    problems = [problem for problem in lint(line, x.sheet) if problem.severity == "error"]
    assert answer in ("E2", "E4") and len(problems) == 1
    (found,) = bench.findings
    assert problems[0].remedy in found.text and problems[0].remedy
