"""Build the firmware of the boards: tools/firmware.py [FOLDER], into build/firmware by default.

The .hex is the application alone, without a boot loader.  It is the same byte for byte wherever it is built: sources in
the order of their names, without paths or dates.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parent.parent
SOURCES = ROOT / "firmware" / "uno"
COMMON = ROOT / "firmware" / "common"
NAME = "slewline-uno.hex"
CHIP = "atmega328p"
FLASH, RAM = 32_256, 2_048  # bytes; of 32 KB of flash a boot loader has the last 512
WORDS = (
    f"-mmcu={CHIP}",
    "-std=gnu99",
    "-O2",
    "-flto",  # a function of another file costs a brake some 50 cycles
    "-Wall",
    "-Wextra",
    "-Wshadow",
    "-Werror",
    "-ffunction-sections",
    "-I.",
    "-I../common",
)
NEEDED = ("avr-gcc", "avr-objcopy", "avr-size", "avr-nm")


# Flags for the common code on this machine: every sanitizer, no warning.
ON_PC = (
    "-std=gnu99",
    "-O1",
    "-g",
    "-Wall",
    "-Wextra",
    "-Wconversion",
    "-Wshadow",
    "-Werror",
    "-fsanitize=undefined,address",
    "-fno-sanitize-recover=all",
    *(f"-I{ROOT / 'firmware' / each}" for each in ("pc", "common", "uno")),  # it has the limits of an Uno
)


class FirmwareError(Exception):
    """A missing program, or the error message of the compiler."""


class Firmware(NamedTuple):
    """The result of a build: the file, bytes of flash and RAM that it takes, and the end of its static RAM.

    For tests, addresses: `levels` of its inputs at the last sample, the time `looked_at` of the last round of its main
    loop, and the `overflows` of its timer, the high half of its time.
    """

    path: Path
    flash: int
    ram: int
    end: int
    levels: int
    looked_at: int
    overflows: int


def missing() -> list[str]:
    """Return the missing programs."""
    return [name for name in NEEDED if shutil.which(name) is None]


def called(*words: str | Path) -> str:
    """Return the output of a program."""
    ran = subprocess.run([str(word) for word in words], cwd=SOURCES, capture_output=True, text=True, check=False)
    if ran.returncode:
        raise FirmwareError(f"{words[0]} ended with {ran.returncode}:\n{ran.stderr}")
    return ran.stdout


def build(folder: Path) -> Firmware:
    """Build the firmware of the Uno into a folder.

    Raises:
        FirmwareError: the compiler is missing, or reports an error.
    """
    if gone := missing():
        raise FirmwareError(f"{', '.join(gone)}: not installed; on Debian:  apt install gcc-avr avr-libc binutils-avr")
    folder = folder.resolve()
    parts = folder / "parts"
    parts.mkdir(parents=True, exist_ok=True)
    objects = []
    for source in sorted(path for each in (SOURCES, COMMON) for path in each.iterdir() if path.suffix in (".c", ".S")):
        objects.append(parts / f"{source.name}.o")
        # By a name relative to the board's folder, so no path can get into the output.
        called("avr-gcc", *WORDS, "-c", os.path.relpath(source, SOURCES), "-o", objects[-1])
    elf, out = parts / "uno.elf", folder / NAME
    called("avr-gcc", *WORDS, "-Wl,--gc-sections", "-o", elf, *objects)
    called("avr-objcopy", "-O", "ihex", "-j", ".text", "-j", ".data", elf, out)
    sizes = dict(
        zip(("text", "data", "bss"), map(int, called("avr-size", elf).splitlines()[1].split()[:3]), strict=True)
    )
    symbols = {
        line.split()[2]: int(line.split()[0], 16) for line in called("avr-nm", "--defined-only", elf).splitlines()
    }
    # addresses of data have a bit of their own
    places = (symbols[name] & 0xFFFF for name in ("_end", "levels", "looked_at", "overflows"))
    return Firmware(out, sizes["text"] + sizes["data"], sizes["data"] + sizes["bss"], *places)


def build_on_pc(folder: Path, program: str) -> Path:
    """Build a program of firmware/pc into a folder, with the code common to boards, for this machine.

    Raises:
        FirmwareError: the compiler is missing, or reports an error.
    """
    if shutil.which("gcc") is None:
        raise FirmwareError("gcc: not installed; on Debian:  apt install gcc libc6-dev")
    pc = ROOT / "firmware" / "pc"
    out = folder.resolve() / program
    called("gcc", *ON_PC, *sorted(COMMON.glob("*.c")), pc / "pc.c", pc / f"{program}.c", "-o", out)
    return out


def report(made: Firmware) -> str:
    """Return a line with the name and the size of a build."""
    return f"{made.path}: {made.flash} of {FLASH} bytes of flash, {made.ram} of {RAM} bytes of RAM"


def main(words: list[str]) -> int:
    """Build the firmware, and print its size; return the exit status."""
    try:
        made = build(Path(words[0]) if words else ROOT / "build" / "firmware")
    except FirmwareError as error:
        print(f"firmware: {error}", file=sys.stderr)
        return 1
    print(report(made))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
