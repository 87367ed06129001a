"""Every channel has its row in each table that is asked for one, and a channel without rows is refused in words."""

from __future__ import annotations

from dataclasses import dataclass, replace

import pytest

import slewline
from slewline.bench.hosting import HOSTS
from slewline.bench.scripts.protocols import SPEECH
from slewline.build import BusHandshake, chip_class
from slewline.core.datasheet import channel
from slewline.core.datasheet.channel import Channel
from slewline.errors import UsageError
from slewline.links.serving import LINES

CHANNELS = [kind for kind in vars(channel).values() if isinstance(kind, type) and issubclass(kind, Channel)]
CY525 = chip_class("cy525")


@dataclass(frozen=True, eq=False)
class Wireless(Channel):
    """A channel of which nobody knows anything."""

    name = "wireless"
    description = "a channel without wires"
    instead = "has no wires"


@dataclass(frozen=True, eq=False)
class Quick(BusHandshake):
    """A bus as the CY525 has one, by another name."""

    name = "quick"


def sister(**sheet: object) -> type:
    return type("Sister", (CY525,), {"sheet": replace(CY525.sheet, part="sister", **sheet)})


@pytest.mark.parametrize("table", [HOSTS, SPEECH, LINES], ids=["HOSTS", "SPEECH", "LINES"])
@pytest.mark.parametrize("kind", [kind for kind in CHANNELS if kind is not Channel])
def test_every_channel_has_its_row(kind, table):
    assert kind in table and kind.instead and kind.description and kind.name


def test_a_channel_without_rows_is_refused_in_words():
    bench = slewline.Bench()
    x = bench.add(sister(channels=(Wireless(),)), name="x")
    allowed = r"allowed BusHandshake, SerialLine, HostPort, FlowBus, AdaptiveLine$"
    with pytest.raises(UsageError, match=rf"^nothing makes a host for Wireless \(a channel without wires\); {allowed}"):
        bench.host(x)
    assert list(bench.parts) == []


def test_a_channel_that_is_derived_from_another_one_goes_by_its_rows():
    bench = slewline.Bench()
    x = bench.add(sister(channels=(Quick(),)), name="x")
    host = bench.host(x, over="quick")
    host.send("R 100\rN 3\rG\r")
    bench.run_until_idle()
    assert x.travel == 3


def test_a_host_that_cannot_be_made_is_in_no_journal(tmp_path):
    bench = slewline.Bench(journal=tmp_path / "j")
    cy545 = chip_class("cy545")
    pins = tuple(replace(pin, role="") if pin.role == "request" else pin for pin in cy545.sheet.pins)
    lame = type("Lame", (cy545,), {"sheet": replace(cy545.sheet, part="lame", pins=pins)})
    y = bench.add(lame, name="y")
    with pytest.raises(slewline.SlewlineError):
        bench.host(y)
    bench.journal.close()
    assert '"do":"host"' not in (tmp_path / "j").read_text().replace(" ", "")
