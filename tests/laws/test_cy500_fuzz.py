"""Nothing that a host or the pins do stops a CY500: RESET brings it back, and all of it can be repeated."""

from __future__ import annotations

from pathlib import Path
from random import Random
from types import MappingProxyType

import pytest

from .fuzz import Mad, check

LETTERS = "ABCDEFGHIJLNOPQRSTU+-0"
ARGUMENTS = {"F": 256, "N": 400, "P": 65_536, "R": 256, "S": 256}
INPUTS = ("abort", "trigger", "wait", "xss", "xdir", "ascii_binary", "io_request")
VALID = (
    "I\rR 253\rF 2\rS 20\rN 3\r+\rG\rA\rB\rC\r-\rP 2\rG\rO\rH\rL\r0\rT\rJ\rI\rF 1\rA\rB\rN 5\rG\rE\rB\rC\rN 3\r0\rQD\r"
)


def text(rnd: Random) -> bytes:
    """A piece of what the mad host sends: mostly commands, some of them wrong, some noise."""
    kind, letter = rnd.random(), rnd.choice(LETTERS)
    if kind < 0.10:
        return rnd.randbytes(rnd.randrange(1, 4))
    if letter == "Q":
        return b"Q"
    count = 2 if letter in "NP" else letter in "FRS"
    if kind < 0.25:
        return bytes([ord(letter), count if rnd.random() < 0.95 else rnd.randrange(6)]) + rnd.randbytes(count)
    return f"{letter} {rnd.randrange(ARGUMENTS[letter])}\r".encode() if letter in ARGUMENTS else f"{letter}\r".encode()


class Mad500(Mad):
    """One run of the fuzz."""

    part = "cy500"
    letters, inputs, valid, program = LETTERS, INPUTS, VALID, b"BCN\3\0\0"
    text = staticmethod(text)
    rest = MappingProxyType({"trigger": 0})


def test_a_mad_host_does_not_stop_a_cy500(tmp_path: Path) -> None:
    check(2_000, tmp_path, Mad500)


@pytest.mark.long
@pytest.mark.timeout(3000)
def test_half_a_million_bytes_do_not_stop_a_cy500(tmp_path: Path) -> None:
    check(500_000, tmp_path, Mad500)
