"""Options of a chipset: how long HostRdy is low."""

from __future__ import annotations

import pytest

import slewline


def test_the_busy_time_of_the_port_may_be_chosen():
    bench = slewline.Bench()
    x = bench.add("mc1151a", busy_ticks=2500, reset_cycles=3)
    bench.record("mc1151a.hostrdy")
    bench.run_until(x.pin("hostrdy").is_(1))
    assert bench.now_ps == 1_000_000 + 3 * 327_680_000
    bench.host(x).packet(0x1A, checksum=False)
    fall, rise = bench.edges("mc1151a.hostrdy")[0][-2:]
    assert rise - fall == 2500 * 40_000


@pytest.mark.parametrize("option", ["busy_ticks", "reset_cycles"])
@pytest.mark.parametrize("value", [0, "2", 1.5])
def test_an_option_that_is_not_a_number_of_clocks_is_refused(option, value):
    with pytest.raises(slewline.UsageError, match=f"{option} {value!r}; allowed 1 or more"):
        slewline.Bench().add("mc1151a", **{option: value})
