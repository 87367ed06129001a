"""The CY525 manual compares it with the CY512 command by command (s.3): the translator does what it says."""

from __future__ import annotations

import pytest

from slewline.translation.proof.prove import prove
from slewline.translation.translate import translate_text
from slewline.translation.translation_report import LineKind
from tests.rows import rows


def lines(text: str, source: str = "cy512", to: str = "cy525") -> list[str]:
    """The commands of the result."""
    found = translate_text(text, source, to).text.splitlines()
    return [line for line in found if line and not line.startswith(";")]


def kind_of(text: str, code: str, source: str = "cy512", to: str = "cy525") -> tuple[LineKind, str]:
    """What became of a line, and the limit that is cited."""
    line = next(line for line in translate_text(text, source, to).report if line.code == code)
    return line.kind, " ".join(verdict.limit for verdict in line.verdicts)


@rows(
    ("written", "becomes"),
    [
        ("A", ["A 0"]),  # A a: the position is a number
        ("X 250", ["D 250"]),  # D d: the delay was X
        ("D", ["X"]),  # X: the run command was D
        ("E\nB\n0\nQ\nD", ["E", "B", "0", "Q", "X"]),
        ("E\nN 5\n+\nG\nT\n0\nQ\nD", ["E", "N 5", "+", "G", "T A", "0", "Q", "X"]),  # T t: has a target
        ("O 0\nO 3", ["O 0", "O 3"]),  # O o: 0 to 3 are full steps in both
        ("B\nC\n+\n-\nN 9\nI", ["B", "C", "+", "-", "N 9", "I"]),  # all others are the same
    ],
)
def test_a_command_that_is_new_or_modified(written: str, becomes: list[str]) -> None:
    found = [line.split("$")[-1] for line in lines(written)]
    rates = ("F ", "R ", "S ", "Z ")
    assert [line for line in found if not line.startswith(rates)] == becomes


def test_the_half_step_is_not_possible_and_is_cited() -> None:
    kind, limit = kind_of("H\nR 50\nN 10\nG\n", "H")
    assert kind is LineKind.IMPOSSIBLE and "half steps" in limit and "CY525" in limit
    kind, limit = kind_of("O 4\n", "O 4")  # here it turns all phases off
    assert kind is LineKind.IMPOSSIBLE and "4-7 the half step after each" in limit


def test_a_move_too_short_for_its_rate_has_a_ramp_in_the_cy525_and_the_difference_is_stated() -> None:
    done = translate_text("A\nR 200\nS 3\nN 20\n+\nG\n", "cy512", "cy525")
    move = done.report.lines[-1]
    assert move.kind is LineKind.NEARLY and 0.3 < move.verdicts[0].off < 0.4
    assert prove(done).proven


def test_r_and_s_become_the_first_rate_the_rate_and_the_slope_of_the_same_ramp() -> None:
    found = lines("A\nR 200\nS 12\nN 900\n+\nG\n")
    letters = [line[0] for line in found]
    assert {"F", "R", "S"} <= {*letters} and letters.index("G") > max(letters.index(each) for each in "FRS")
    kind, _ = kind_of("A\nR 200\nS 12\nN 900\n+\nG\n", "R 200")
    assert kind is LineKind.NEARLY


def test_the_rate_of_the_cy512_went_up_to_255_and_that_of_the_cy525_to_127() -> None:
    found = lines("A\nR 255\nS 12\nN 900\n+\nG\n")
    (rate,) = [int(line.split()[1]) for line in found if line.startswith("R")]
    assert rate <= 127


def test_a_factor_divides_the_rate() -> None:
    (plain,) = [line for line in lines("R 200\nN 9\nG\n") if line.startswith("R")]
    (halved,) = [line for line in lines("R 200\nF 2\nN 9\nG\n") if line.startswith("R")]
    assert int(halved.split()[1]) < int(plain.split()[1])


@rows(
    ("written", "limit"),
    [
        ("A 500", "position to zero"),
        ("H", "until it is stopped"),
        ("F 90", "start and end"),
        ("O 9", "above 3: phases off"),
    ],
)
def test_new_features_of_the_cy525_are_missing_in_the_cy512(written: str, limit: str) -> None:
    kind, cited = kind_of(f"{written}\nN 9\nG\n", written, "cy525", "cy512")
    assert kind is LineKind.IMPOSSIBLE and limit in cited


def test_labels_become_addresses_in_a_part_without_labels() -> None:
    assert lines("E\nB$B\nC\nJ B\nQ\nX\n", "cy525", "cy512")[:4] == ["E", "B", "C", "J 0"]


@pytest.mark.parametrize("text", ["E\nP 9\nJ 0\nQ\nD\n", "E\nN 3\nG\nL 4,0\n0\nQ\nD\n"])
def test_addresses_of_the_cy512_are_counted_again(text: str) -> None:
    found = lines(f"A\nR 50\n{text}")
    assert any(line.startswith("A$") for line in found)
