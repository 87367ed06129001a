"""What keeps a server small that runs for months, and how other threads speak to it."""

from __future__ import annotations

import pytest

from slewline.links import server as module
from slewline.links.time import bench_exchange
from slewline.links.views.server_status import as_line, status

from .conftest import Threaded


def test_old_findings_are_forgotten_and_all_are_counted(lockstep):
    server, _ = lockstep()
    x = server.bench["x"]
    for number in range(2 * module.KEPT_FINDINGS + 1):
        x.finding("test", str(number))
    assert server.found == 2001
    assert [found.text for found in x.findings] == [str(number) for number in range(1001, 2001)]
    assert len(status(server)["chips"]["x"]["findings"]) == 20
    assert "2001 findings" in as_line(server)
    server.close()


def test_the_distant_past_is_forgotten_and_its_steps_are_counted(lockstep, monkeypatch):
    monkeypatch.setattr(bench_exchange, "KEPT_STRETCHES", 2)
    monkeypatch.setattr("slewline.core.motion.kept.FEWEST", 0)
    server, line = lockstep()
    x = server.bench["x"]
    server.bench.run(0)
    server.pace.start()
    for text in (b"Po", b"S50", b"T200", b"R20", b"+40", b"-30", b"+60", b"-10", b"+5", b"E"):
        line.take(text + b"\r")
        while not server.pace.pass_time():
            pass
    counts = []
    for _ in range(50):
        server.bench.run("20 ms")
        counts.append(server.steps_of(x))
    assert counts[-1] == 40 + 30 + 60 + 10 + 5
    assert len(x.axes[0].past) <= 4
    assert len(x.steps()) < 145  # it is no longer all there
    server.close()


def test_a_function_is_called_in_the_thread_of_the_server(lockstep):
    server, _ = lockstep()
    with Threaded(server) as running:
        assert running.do(lambda: running.bench.now_ps) == 10**9
        with pytest.raises(ZeroDivisionError):
            running.do(lambda: 1 / 0)
        assert running.do(lambda: 2) == 2


def test_stopping_twice_and_after_the_end_is_harmless(lockstep):
    server, _ = lockstep()
    with Threaded(server):
        server.stop()
        server.stop()
    server.stop()
