"""Nothing that a host or the pins do stops a CY512: RESET brings it back, and all of it can be repeated."""

from __future__ import annotations

from pathlib import Path
from random import Random

import pytest

from .fuzz import INPUTS, Mad, check

LETTERS = "ABCDEFGHIJLNOPQRSTUVWX+-0"
ARGUMENTS = {"F": 256, "J": 50, "N": 400, "O": 10, "P": 65_536, "R": 258, "S": 256, "V": 6, "X": 4}
VALID = (
    "I\rA\rR 255\rF 2\rS 20\rN 3\r+\rG\rB\rC\r-\rP 5\rO 2\rH\rV 3\rX 1\r0\rL 1,0\rW\rI\rA\rF 1\rS 0\rN 3\rP 5\r"
    "E\rB\rC\rL 2,0\r0\rQD\rJ 1\r"
)


def text(rnd: Random) -> bytes:
    """A piece of what the mad host sends: mostly commands, some of them wrong, some noise."""
    kind, letter = rnd.random(), rnd.choice(LETTERS)
    if kind < 0.10:
        return rnd.randbytes(rnd.randrange(1, 4))
    if letter == "Q":
        return b"Q"
    count = 2 if letter in "LNPX" else letter in "FJORSV"
    if kind < 0.25:
        return bytes([ord(letter), count if rnd.random() < 0.95 else rnd.randrange(6)]) + rnd.randbytes(count)
    if letter == "L":
        return b"L %d,%d\r" % (rnd.randrange(5), rnd.randrange(12))
    return f"{letter} {rnd.randrange(ARGUMENTS[letter])}\r".encode() if letter in ARGUMENTS else f"{letter}\r".encode()


class Mad512(Mad):
    """One run of the fuzz."""

    part = "cy512"
    letters, inputs, valid = LETTERS, (*INPUTS, "terminate"), VALID
    text = staticmethod(text)


def test_a_mad_host_does_not_stop_a_cy512(tmp_path: Path) -> None:
    check(2_000, tmp_path, Mad512)


@pytest.mark.long
@pytest.mark.timeout(3000)
def test_half_a_million_bytes_do_not_stop_a_cy512(tmp_path: Path) -> None:
    check(500_000, tmp_path, Mad512)
