"""Numbers that are written with commas, and as which number we write them."""

from __future__ import annotations

import pytest

from slewline.core.datasheet.units import quantity
from slewline.core.messages.decimal_comma import without_comma
from slewline.core.time.timebase import hertz, picoseconds
from slewline.drive.terminals import steps_a_second
from slewline.errors import SlewlineError

DECIMALS, THOUSANDS = "with a decimal point", "with no sign between the digits"
READERS = [  # of text with a number; what is written, the remedy at the end of the answer
    (picoseconds, "0,5 s", f"write 0.5 s, {DECIMALS}"),
    (picoseconds, ",5 s", f"write 0.5 s, {DECIMALS}"),
    (picoseconds, "1,000,000 us", f"write 1000000 us, {THOUSANDS}"),
    (picoseconds, "1 000 ms", f"write 1000 ms, {THOUSANDS}"),
    (hertz, "3,58 MHz", f"write 3.58 MHz, {DECIMALS}"),
    (lambda text: quantity(text, "A", "current"), "1,4 A", f"write 1.4 A, {DECIMALS}"),
    (lambda text: quantity(text, "kg m2", "inertia"), "6,8 g cm2", f"write 6.8 g cm2, {DECIMALS}"),
    (steps_a_second, "1'000 steps/s", f"write 1000 steps/s, {THOUSANDS}"),
]


@pytest.mark.parametrize(("read", "text", "remedy"), READERS, ids=[text for _, text, _ in READERS])
def test_every_reader_explains_how_a_number_with_commas_is_written(read, text, remedy):
    with pytest.raises(SlewlineError) as caught:
        read(text)
    assert str(caught.value).endswith(f"; {remedy}")


@pytest.mark.parametrize("text", ["", "5", "0.5 s", "1,2,3", "1,,5", "a,5", "1.5,2", "12,34,567", 5, None, "1,5,"])
def test_other_texts_have_no_remedy(text):
    assert without_comma(text) == ""
