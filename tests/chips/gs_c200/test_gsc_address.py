"""Modules that share a line: addresses, who answers, and who keeps silent.

SEL2 SEL1 SEL0    0 0 0   1 0 0   0 1 0   1 1 0   0 0 1   1 0 1   0 1 1   1 1 1
address             7       6       5       4       3       2       1     none: point-to-point
"""

from __future__ import annotations

import pytest
from gsc import C200S, MS, NINE_SIX, STR, base, both

import slewline
from slewline.errors import UsageError

CHARACTER = 11 * 10**12 // 9600
ADDRESSES = {"000": 7, "100": 6, "010": 5, "110": 4, "001": 3, "101": 2, "011": 1}  # by SEL2 SEL1 SEL0
BY_WEIGHT = {"000": 7, "100": 3, "010": 5, "110": 1, "001": 6, "101": 2, "011": 4}  # SEL2 counting 4, SEL0 1


def sel(address: int) -> dict[str, int]:
    """The straps of an address."""
    straps = next(straps for straps, found in ADDRESSES.items() if found == address)
    return {f"sel{2 - n}": int(level) for n, level in enumerate(straps)}


class Shared:
    """Modules x1, x2 ... on one line, with their addresses on their user inputs, too: V2 tells who answers."""

    def __init__(self, part: str, *addresses: int, **straps: int) -> None:
        self.bench = slewline.Bench()
        self.chips = [self._add(part, f"x{n}", address, straps) for n, address in enumerate(addresses, 1)]
        self.host = self.bench.host(*self.chips)

    def _add(self, part: str, name: str, address: int, straps: dict[str, int]) -> slewline.core.chip.Chip:
        inputs = {f"ui{n + 1}": address >> n & 1 for n in range(3)}
        return self.bench.add(part, name=name, straps={**NINE_SIX, "chs": 0, **sel(address), **inputs, **straps})

    def wire(self, data: str | bytes) -> bytes:
        """What comes back within 200 ms."""
        before = len(self.host.received)
        self.host.write(data)
        self.bench.run("200 ms")
        return bytes(self.host.received[before:])


# ----------------------------------------------------------------------------------------------------------- addresses
@both
@pytest.mark.parametrize("straps", ADDRESSES)
@pytest.mark.fact("GSC-ADDR-1", "GSC-CON-ADDR-ORDER")
def test_the_straps_set_the_address_with_sel2_counting_one(part: str, straps: str) -> None:
    rig = base(part, **{f"sel{2 - n}": int(level) for n, level in enumerate(straps)})
    answers = [rig.wire(f"{address}F\r", wait="200 ms") for address in range(1, 8)]
    assert answers == [b"R\r" if address == ADDRESSES[straps] else b"" for address in range(1, 8)]


@both
@pytest.mark.parametrize("straps", BY_WEIGHT)
@pytest.mark.fact("GSC-CON-ADDR-ORDER")
def test_a_module_can_read_its_straps_as_the_pin_description_orders_them(part: str, straps: str) -> None:
    levels = {f"sel{2 - n}": int(level) for n, level in enumerate(straps)}
    rig = base(part, options={"pin_order": True}, **levels)
    answers = [rig.wire(f"{address}F\r", wait="200 ms") for address in range(1, 8)]
    assert answers == [b"R\r" if address == BY_WEIGHT[straps] else b"" for address in range(1, 8)]


@both
@pytest.mark.fact("GSC-CON-ADDR-ORDER")
def test_an_address_can_be_given_directly(part: str) -> None:
    rig = base(part, options={"address": 6})
    assert rig.wire("6F\rF\r", wait="200 ms") == b"R\r"
    rig = base(part, options={"address": 0}, sel0=0)
    assert rig.wire("F\r") == b"R\r"
    with pytest.raises(UsageError, match=r"address 8; allowed 0\.\.7, None"):
        base(part, options={"address": 8})


@both
@pytest.mark.fact("GSC-ADDR-2", "GSC-CON-SEL-POLARITY")
def test_straps_that_are_all_open_mean_point_to_point_and_all_low_address_7(part: str) -> None:
    assert base(part).wire("F\r") == b"R\r"
    assert base(part, sel0=1, sel1=1, sel2=1).wire("F\r") == b"R\r"
    rig = base(part, sel0=0, sel1=0, sel2=0)
    assert rig.wire("F\r", wait="1 s") == b""
    assert rig.wire("7F\r") == b"R\r"


@both
@pytest.mark.fact("GSC-ADDR-3", "GSC-ADDR-9")
def test_seven_modules_share_a_line_without_any_other(part: str) -> None:
    line = Shared(part, 1, 2, 3, 4, 5, 6, 7)
    assert [line.wire(f"{address}F\r") for address in range(1, 8)] == [b"R\r"] * 7
    assert [line.wire(f"{address}V2\r") for address in range(1, 8)] == [b"V%d0\r" % address for address in range(1, 8)]
    assert [line.wire(f"{address}F\r") for address in ("0", "8", "9", "", "*")] == [b""] * 5
    assert [found.code for found in line.bench.findings] == ["address"] * 5  # of the host


@both
@pytest.mark.fact("GSC-ADDR-4")
def test_the_address_comes_first(part: str) -> None:
    rig = base(part, chs=1, **sel(2))
    rig.prg()
    assert rig.wire("2A36\r") == b"YY\r"
    assert rig.listed() == ["A3"]
    rig = base(part, **sel(2))
    rig.prg()
    assert rig.wire("2A3\r") == b"Y\r"
    assert rig.listed() == ["A3"]


@both
@pytest.mark.fact("GSC-ADDR-5", "GSC-ADDR-9")
def test_a_string_for_another_address_is_not_obeyed(part: str) -> None:
    rig = base(part, **sel(2))
    rig.start(*STR, "+999999")
    for foreign in ("5K\r", "0K\r", "K\r"):
        assert rig.wire(foreign, wait="1 s") == b""
    before = rig.x.position
    rig.bench.run("1 s")
    assert rig.x.position == before + 1000
    assert rig.wire("2K\r") == b"Y\r"
    assert not rig.x.moving and rig.wire("2F\r") == b"R\r"


@both
@pytest.mark.fact("GSC-ADDR-6")
def test_an_answer_has_no_address(part: str) -> None:
    rig = base(part, **sel(5))
    assert rig.wire("5F\r") == b"\x52\x0d"
    assert rig.wire("5V2\r") == b"V70\r"
    assert rig.wire("5V9\r") == b"E2\r"


@both
@pytest.mark.fact("GSC-ADDR-7", "GSC-UND-EMPTY")
def test_a_string_without_address_is_ignored_and_so_is_an_address_alone(part: str) -> None:
    rig = base(part, **sel(2))
    for line in ("F\r", "\r", "2\r"):
        assert rig.wire(line, wait="1 s") == b""
    assert rig.wire("2F\r") == b"R\r"
    assert rig.codes == []


@both
@pytest.mark.fact("GSC-ADDR-8")
def test_point_to_point_a_leading_digit_is_an_unknown_command(part: str) -> None:
    rig = base(part)
    assert rig.wire("2F\r") == b"E4\r"
    rig.prg()
    assert rig.wire("2A3\r") == b"E4\r"


# ------------------------------------------------------------------------------------------------- checksums and faults
@both
@pytest.mark.fact("GSC-ADDR-10")
def test_the_address_takes_part_in_the_checksum(part: str) -> None:
    rig = base(part, chs=1, **sel(2))
    assert rig.wire("2Fx\r") == b"RR\r"
    assert rig.wire("2FV\r") == b"E1v\r"


@both
@pytest.mark.fact("GSC-ADDR-11")
def test_only_the_addressed_module_reports_a_fault(part: str) -> None:
    line = Shared(part, 2, 5, chs=1)
    assert line.wire("3F \r") == b""
    assert line.wire("2F \r") == b"E1v\r"
    found = [(each.source, each.code) for each in line.bench.findings]
    assert found == [("host", "address"), ("x1", "E1")]
    line.host.write("5")
    line.host.write("F", "parity")
    assert line.wire("x\r") == b"E1v\r"
    assert [each.source for each in line.bench.findings[2:]] == ["x2"]


@both
@pytest.mark.parametrize("fault", ["parity", "framing"])
@pytest.mark.fact("GSC-UND-ADDR-FAULT", "GSC-UND-FRAMING")
def test_no_module_answers_a_faulty_address(part: str, fault: str) -> None:
    line = Shared(part, 1, 2)
    line.host.write("2", fault)
    assert line.wire("F\r") == b""
    line.host.write("2")
    line.host.write("F", fault)
    assert line.wire("\r") == b"E1\r"
    assert line.wire("2F\r") == b"R\r"


@both
@pytest.mark.fact("GSC-ADDR-12")
def test_an_address_costs_one_character_of_time(part: str) -> None:
    for straps, line, characters in (({}, "FV\r", 6), (sel(2), "2Fx\r", 7)):
        rig = base(part, chs=1, **straps)
        assert rig.wire(line) == b"RR\r"
        assert rig.bench.now_ps == MS + characters * CHARACTER + MS  # a millisecond before, another before the answer


@pytest.mark.parametrize(("straps", "who"), [(({}, {}), "x, y"), (({"sel2": 0}, {}), "y")])
def test_modules_without_an_address_on_a_line_are_reported(straps: tuple[dict[str, int], ...], who: str) -> None:
    bench = slewline.Bench()
    modules = [bench.add(C200S, name, straps=own) for name, own in zip("xy", straps, strict=True)]
    line = bench.host(*modules)
    (told,) = line.findings
    assert told.code == "same-address"
    assert told.text.startswith(f"{who} have no address on a shared line: all of them answer; strap")


@both
@pytest.mark.fact("GSC-UND-MULTI-TXD")
def test_two_modules_with_one_address_garble_their_answers(part: str) -> None:
    line = Shared(part, 2, 2)
    assert line.wire("2F\r") == b"R\r"  # the same bits at the same time
    (told,) = line.bench.findings
    assert (told.code, told.text[:34]) == ("same-address", "x1, x2 have the same address on on")
    assert told.text.endswith("all of them answer; strap sel2, sel1, sel0 differently")
    line.chips[1].pin("ui1").drive(1)
    line.chips[1].pin("ui2").drive(0)
    assert line.wire("2V2\r") == b"V30\r"  # 1 and 2 at once, with the parity of either
    assert {found.code for found in line.bench.findings} == {"same-address", "conflict"}
    assert line.host.faulty == 1
