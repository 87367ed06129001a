"""The outside of a run: what is told to it, what is only a part of that, and calls that only queue."""

from __future__ import annotations

import json

import pytest

import slewline
from slewline.bench.scripts.script import run_script
from slewline.core.time.kernel import Kernel
from slewline.core.time.outside import Outside
from slewline.parts.boards.isa import Isa


def listened(bench: slewline.Bench) -> list[tuple[int, str, dict[str, object]]]:
    """All inputs of a bench: when, what, and to what."""
    heard = []
    bench.kernel.outside.on_input.add(lambda do, what: heard.append((bench.now_ps, do, what)))
    return heard


def test_every_input_is_reported_once_with_plain_data():
    bench = slewline.Bench()
    heard = listened(bench)
    x = bench.add("cy525", name="x", rate=40)
    host = bench.host(x, name="pc")
    x.pin("abort").drive(0, at="1 ms")
    host.send(b"R 1\r")
    bench.run("2 ms")
    x.power(False)
    x.power(False)  # it is off already
    x.pin("abort").release()
    assert [(ps, do) for ps, do, _ in heard] == [
        (0, "add"), (0, "host"), (0, "input"), (10**9, "drive"), (2 * 10**9, "run"), (2 * 10**9, "power"),
        (2 * 10**9, "drive"),
    ]  # fmt: skip
    assert heard[3][2] == {"pin": "x.abort", "level": 0} and heard[5][2] == {"chip": "x", "on": False}
    assert json.loads(json.dumps([what for *_, what in heard])) == [what for *_, what in heard]


def test_nested_calls_are_not_reported_at_any_depth():
    outside, heard = Outside(), []
    outside.on_input.add(lambda do, what: heard.append(do))
    with outside.nested():
        outside.record("no")
        with outside.nested():
            outside.record("no")
        outside.record("no")
    outside.record("yes")
    with pytest.raises(ZeroDivisionError), outside.nested():
        raise ZeroDivisionError
    outside.record("again")
    assert heard == ["yes", "again"]


def test_the_second_half_of_a_nested_pulse_is_nested_too():
    bench = slewline.Bench()
    x = bench.add("cy525", name="x")
    heard = listened(bench)
    with bench.kernel.outside.nested():
        x.pin("abort").pulse(0, "1 ms", at="1 ms")
        x.pin("wait").drive(0, at="2 ms")
    x.pin("dowhile").pulse(0, "1 ms")
    bench.run("5 ms")
    assert [what["pin"] for _, do, what in heard if do == "drive"] == ["x.dowhile", "x.dowhile"]
    assert x.pin("abort").level == 1 and x.pin("wait").level == 0


def test_a_script_is_one_input():
    bench = slewline.Bench()
    x = bench.add("cy525", name="x")
    host = bench.host(x)
    bench.part("serial_port", "port")
    heard = listened(bench)
    run_script(bench, host, "@reset\n@drive wait=0\n@pulse abort=0 1 ms\n@power off\n@power on\n@release wait@40 ms\n")
    bench.run("50 ms")
    assert [do for _, do, _ in heard] == ["script", "run"]


def test_calls_are_queued_where_requested():
    bench = slewline.Bench()
    x = bench.add("cy525", name="x", rate=40, number=300)
    host = bench.host(x)
    heard = listened(bench)
    with bench.kernel.outside.queued():
        assert host.verify(3) is None
        assert bench.now_ps == 0
    assert [(do, what["verb"]) for _, do, what in heard] == [("input", "read_group")]
    bench.run_until_idle()
    assert host.received[:2] == bytes([1, 44])
    assert host.verify(3)[:2] == bytes([1, 44])  # and outside of it they wait


@pytest.mark.parametrize("part", ["mc1451a", "gs-c200s"])
def test_calls_to_other_hosts_only_queue_too(part):
    bench = slewline.Bench()
    host = bench.host(bench.add(part))
    bench.run("20 ms")
    then = bench.now_ps
    with bench.kernel.outside.queued():
        host.ask("F") if part == "gs-c200s" else host.query("GET_STATUS")
    assert bench.now_ps == then and not host.idle
    bench.run_until_idle()
    assert host.answers if part == "gs-c200s" else host.received


def test_without_a_bench_calls_only_queue():
    kernel = Kernel()
    board = Isa(kernel, "board", base=0x240, card="pmd")
    assert board.inp(0x240) is None
    assert kernel.now == 0 and not board.idle
    kernel.settle()


def test_after_a_replay_calls_of_the_host_wait_again(tmp_path):
    bench = slewline.Bench(journal=tmp_path / "journal")
    host = bench.host(bench.add("cy525", name="x", number=300))
    assert host.verify(3)[:2] == bytes([1, 44])
    again = slewline.replay(tmp_path / "journal")
    assert again["host"].verify(3)[:2] == bytes([1, 44])
    assert again.now_ps > bench.now_ps
