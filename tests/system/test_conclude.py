"""What a chip has to say when everybody rests, or a run is over: told once, wherever it is, and again in a replay."""

from __future__ import annotations

import pytest
import serial

import slewline
import slewline.testing
from slewline.build import chip_class
from slewline.cli.main import invoke
from slewline.links.lines.pace import Lockstep, Paced
from slewline.links.server import Server
from slewline.testing import aio, rig
from slewline.testing.endpoints import running
from tests.links.conftest import STRAPS, Client, Threaded


class Forgetful(chip_class("gs-c200s")):
    """A module whose host leaves a program half entered, whenever one is in the memory."""

    def left_over(self):
        return [("left", f"line {self.said} is left")] if self.said else []

    said = 1


def told(bench):
    return [(found.code, found.text, found.time_ps) for found in bench.findings if found.code == "left"]


@pytest.fixture
def bench():
    found = slewline.Bench()
    found.add(Forgetful, name="x", straps=STRAPS)
    return found


def test_a_run_until_idle_reports_it_once(bench):
    bench.run("1 ms")
    assert told(bench) == []
    bench.run_until_idle()
    now = bench.now_ps
    bench.run_until_idle()
    bench.run("1 ms")
    bench.run_until_idle()
    assert told(bench) == [("left", "line 1 is left", now)]


def test_it_is_reported_again_when_it_has_changed_or_was_not_left_in_between(bench):
    for bench["x"].said in (1, 2, 0, 2):
        bench.run_until_idle()
    assert [text for _, text, _ in told(bench)] == ["line 1 is left", "line 2 is left", "line 2 is left"]


def test_a_host_that_has_more_to_say_has_left_nothing_over(bench):
    host = bench.host(bench["x"])
    host.send("F\r")
    bench.run("1 ms")
    bench.conclude()
    assert told(bench) == []
    bench.run_until_idle()
    assert len(told(bench)) == 1


def test_in_asyncio_too(bench):
    aio.run(bench.until_idle())
    assert len(told(bench)) == 1


def test_a_replay_reports_it_at_the_same_instants(tmp_path):
    path = tmp_path / "journal.jsonl"
    bench = slewline.Bench(journal=path)
    host = bench.host(bench.add(Forgetful, name="x", straps=STRAPS))
    bench.run_until_idle()
    host.send("F\r")
    bench.run_until_idle()
    bench.run("1 ms")
    bench.journal.close()
    again = slewline.replay(path, allow_code=True)
    assert told(again) == told(bench) != []
    assert path.read_text().count('"conclude"') == 1  # and nothing where nothing has changed


def test_a_program_that_hangs_up_has_left_it_over():
    with serial.serial_for_url("slewline://gs-c200s?name=x", 9600, 7, "O", 2, timeout=1):
        module = rig.NAMED["x"]
        module.chip.left_over = lambda: [("left", "it is left")]
        assert told(module.bench) == []
    rig.NAMED.clear()
    assert len(told(module.bench)) == 1


def test_a_module_of_a_test_reports_it_in_until_idle_and_in_the_report_of_a_failure():
    module = running(Forgetful)
    assert told(module.bench) == []
    module.until_idle()
    assert len(told(module.bench)) == 1
    module.close()
    module = running(Forgetful)
    assert "left: line 1 is left" in module.report()
    module.close()


@pytest.mark.parametrize("pace", [Lockstep, Paced])
def test_a_server_reports_it_when_a_host_has_left(pace):
    bench = slewline.Bench()
    server = Server(bench, pace(bench))
    line = server.line(bench.add(Forgetful, name="x", straps=STRAPS))
    where = server.tcp(line, "127.0.0.1:0").where
    with Threaded(server) as served:
        host = Client(where)
        host.send(b"F\r")
        assert host.read(b"R\r").endswith(b"R\r")
        assert served.do(lambda: told(bench)) == []
        host.close()
        served.until(lambda: told(bench))
    assert len(told(bench)) == 1


def test_a_command_whose_end_does_not_come_is_reported_unless_time_is_stopped():
    bench = slewline.Bench()
    server = Server(bench, Lockstep(bench))
    line = server.line(bench.add("gs-c200s", name="x", straps=STRAPS))
    server.pace.start()
    line.take(b"V1")
    while not server.pace.pass_time():
        pass
    server.pace.pause_time()
    for _ in range(3):
        line.look_for_ends()
    assert bench.findings == []
    server.pace.go()
    line.look_for_ends()
    assert bench.findings == []
    line.look_for_ends()
    assert [found.code for found in bench.findings] == ["unfinished"]
    server.close()


def test_a_line_that_has_just_begun_is_not_reported_for_the_late_one_before_it():
    bench = slewline.Bench()
    server = Server(bench, Lockstep(bench))
    line = server.line(bench.add("gs-c200s", name="x", straps=STRAPS))
    server.pace.start()
    for data in (b"V1", b"\rF"):
        line.take(data)
        while not server.pace.pass_time():
            pass
        line.look_for_ends()
        assert bench.findings == []
    line.look_for_ends()
    assert [found.code for found in bench.findings] == ["unfinished"]
    server.close()


def test_a_server_that_ends_reports_it():
    bench = slewline.Bench()
    server = Server(bench, Lockstep(bench))
    bench.add(Forgetful, name="x", straps=STRAPS)
    server.close()
    assert len(told(bench)) == 1


@pytest.mark.parametrize("how", [(), ("--until", "50 ms"), ("--timeout", "50 ms")])
def test_slewline_run_reports_it_however_it_ends(how, tmp_path, monkeypatch, capfd):
    monkeypatch.setattr(Forgetful.__base__, "left_over", Forgetful.left_over)
    monkeypatch.setattr(Forgetful.__base__, "said", 1, raising=False)
    script = tmp_path / "script.txt"
    script.write_text("S10\nT100\nR50\n+\n" if how else "F\n")  # + moves for ever
    invoke(["run", str(script), "--chip", "gs-c200s", *how])
    assert capfd.readouterr().out.count("line 1 is left") == 1
