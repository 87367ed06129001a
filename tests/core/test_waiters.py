"""A net that never changes does not gather the waits that others have ended."""

from __future__ import annotations

from slewline.core.time.kernel import Kernel
from slewline.core.wires.net import Net
from slewline.core.wires.waiters import STALE
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
    assert len(quiet.waiters) <= STALE + 1
