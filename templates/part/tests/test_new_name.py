"""The facts of the NEW-NAME: each test proves the facts of conformance.toml that it names."""

from __future__ import annotations

import pytest
import slewline

from new_name import NewName

MS = 10**9  # virtual time is counted in picoseconds


@pytest.fixture
def bench() -> slewline.Bench:
    """Return a bench with only the part, and record its contact; virtual time begins at 0."""
    bench = slewline.Bench()
    bench.part(NewName, name="relay")
    bench.record("relay.contact")
    return bench


def moved(bench: slewline.Bench) -> list[int]:
    """Run until idle; return the instants at which the contact has moved."""
    bench.run_until_idle()
    times, _ = bench.edges("relay.contact")
    return [int(time) for time in times]


@pytest.mark.fact("CONTACT", "TIME-DELAY")
def test_the_contact_follows_the_coil(bench: slewline.Bench) -> None:
    relay = bench["relay"]
    relay.pin("coil").drive(1, at="10 ms")
    relay.pin("coil").drive(0, at="30 ms")
    bench.run("40 ms")
    assert moved(bench) == [15 * MS, 35 * MS]
    assert relay.findings == []


@pytest.mark.fact("SHORT")
def test_a_short_pulse_does_not_move_the_contact(bench: slewline.Bench) -> None:
    relay = bench["relay"]
    relay.pin("coil").drive(1, at="10 ms")
    relay.pin("coil").drive(0, at="14 ms")
    bench.run("40 ms")
    assert moved(bench) == []
    assert [finding.code for finding in relay.findings] == ["short"]


@pytest.mark.fact("CONTACT")
def test_a_chip_opens_and_closes_it() -> None:
    bench = slewline.Bench()
    x = bench.add("cy525", name="x")
    relay = bench.part(NewName, to=x, delay="1 ms")
    host = bench.host(x)
    for command, level in (("C", 0), ("B", 1), ("C", 0)):
        host.send(f"{command}\r")
        bench.run_until_idle()
        assert (relay.pin("coil").level, relay.pin("contact").level) == (level, level)
