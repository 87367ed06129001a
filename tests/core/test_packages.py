"""Where pins are on their packages."""

from __future__ import annotations

from itertools import chain

from slewline.chips import PARTS, sheet_of
from slewline.core.datasheet.packages import packages
from slewline.core.datasheet.table import Pin
from tests.rows import rows


def pins(count):
    return [Pin(n, f"p{n}", "in", "") for n in range(1, count + 1)]


def run(first, last):
    way = 1 if last > first else -1
    return tuple(f"p{n}" for n in range(first, last + way, way))


def test_a_package_of_40_pins_has_two_rows():
    (one,) = packages(pins(40))
    assert (one.name, one.numbered, one.square) == ("", True, False)
    assert one.sides == (run(1, 20), run(40, 21))


def test_a_package_of_68_pins_has_four_sides_and_pin_1_in_the_middle_of_the_upper_one():
    (one,) = packages(pins(68))
    assert one.square
    assert one.sides == (run(10, 26), run(27, 43), run(60, 44), run(9, 1) + run(68, 61))


def test_a_package_has_a_size_in_which_they_are_made_and_pins_that_are_not_in_the_sheet_keep_their_numbers():
    (one,) = packages(pins(11))
    assert one.sides == (run(1, 7), (14, 13, 12, *run(11, 8)))
    (large,) = packages(pins(87))
    assert sum(map(len, large.sides)) == 88


def test_a_chipset_has_several_packages_by_the_rows_of_its_pins_or_by_their_names():
    rows = [(1, "pulse1", "out"), (2, "io_vcc2", "power"), (2, "atrest1", "out"), (1, "cp_gnd1", "power")]
    found = packages([Pin(*row, "") for row in rows])
    assert [one.name for one in found] == ["I/O chip", "CP chip"]
    assert found[0].sides[0][:2] == ("pulse1", "io_vcc2")
    told = [Pin(*row, "", where=f"{'I/O' if n < 2 else 'CP'} chip; pin descriptions") for n, row in enumerate(rows)]
    assert packages(told) == found


def test_pins_without_a_number_are_in_the_order_of_the_manual_or_next_to_the_package():
    (unknown,) = packages([Pin(0, name, "in", "") for name in "abc"])
    assert (unknown.numbered, unknown.sides) == (False, (("a", "b"), ("c",)))
    (some,) = packages([*pins(8), Pin(0, "late", "in", "")])
    assert some.loose == ("late",)


@rows("part", PARTS)
def test_every_pin_of_every_part_is_in_one_place(part):
    sheet = sheet_of(part)
    placed = [name for one in packages(sheet.pins) for name in (*chain(*one.sides), *one.loose)]
    assert sorted(name for name in placed if isinstance(name, str)) == sorted(pin.name for pin in sheet.pins)
