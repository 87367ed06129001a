"""A bench that keeps all of its past says so once, before that takes much memory."""

from __future__ import annotations

import warnings

import pytest

import slewline
from slewline.errors import LongPast


def moves(bench: slewline.Bench, number: int) -> None:
    host = bench.host(bench.add("cy525"))
    host.send("A 0\rF 10\rR 100\rS 240\rN 5\r" + "+\rG\r" * number)
    bench.run_until_idle()


def test_a_bench_that_keeps_everything_warns_once_and_names_keep(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("slewline.core.motion.kept.MANY", 40)
    bench = slewline.Bench()
    with pytest.warns(LongPast, match=r"about 20 motions of an axis are kept.*Bench\(keep='10 s'\)") as found:
        moves(bench, 60)
    assert len(found) == 1
    assert found[0].filename == __file__


def test_one_that_keeps_the_last_seconds_does_not(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("slewline.core.motion.kept.MANY", 40)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        moves(slewline.Bench(keep="10 s"), 60)


def test_nor_does_one_that_makes_fewer(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("slewline.core.motion.kept.MANY", 400)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        moves(slewline.Bench(), 60)
