"""A net that never changes does not gather the waits that others have ended."""

from __future__ import annotations

import pytest

import slewline
from slewline.chips import PARTS
from slewline.core.time.kernel import Kernel
from slewline.core.wires.net import STALE, Net
from slewline.core.wires.waits import first_of


def test_ended_waits_are_sorted_out_of_a_quiet_net() -> None:
    kernel = Kernel()
    quiet = Net(kernel, "quiet", pull=1)
    woken = []

    async def waits() -> None:
        for number in range(20 * STALE):
            woken.append(await first_of(kernel, number + 1, (quiet, 0)))

    kernel.spawn(waits, name="waits")
    kernel.run(30 * STALE)
    assert woken == [None] * (20 * STALE)
    assert len(quiet.waiters or ()) <= STALE + 1


@pytest.mark.parametrize("part", sorted(PARTS))
def test_a_long_dialogue_leaves_no_ended_waits_on_any_wire(part: str) -> None:
    """Bytes that are exchanged as a value wake their ends without an edge of the wires for which these wait."""
    bench = slewline.Bench()
    host = bench.host(bench.add(part, "x"))
    line = {"mc": "GET_STATUS", "gs": "F\r", "cy": "R 5\r"}[part[:2]]
    for _ in range(3 * STALE):
        host.send(line)
    bench.run_until_idle()
    assert (
        max(len(pin.net.waiters or ()) for owner in (bench.chips["x"], host) for pin in owner.pins.values())
        <= STALE + 1
    )
