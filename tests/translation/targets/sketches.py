"""Sketches: compiled with the core of Arduino (package arduino-core-avr), and run by an emulated Uno.

The libraries for steppers are stand-ins of ours (folder arduino): the real ones are in no registry that tests may use.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from tests.firmware.needs import AVR8JS

HERE = Path(__file__).parent
CORE = Path("/usr/share/arduino/hardware/arduino/avr")
NEEDED = ("avr-gcc", "avr-g++", "avr-objcopy", "node")
WORDS = (
    "-mmcu=atmega328p",
    "-DF_CPU=16000000L",
    "-DARDUINO=10819",
    "-DDECIMAL_DIG=__DECIMAL_DIG__",  # which an old avr-gcc has for C alone
    "-Os",
    "-ffunction-sections",
    "-fdata-sections",
    f"-I{CORE / 'cores' / 'arduino'}",
    f"-I{CORE / 'variants' / 'standard'}",
)
CPP = ("-std=gnu++11", "-fno-exceptions", "-fno-threadsafe-statics")
HZ = 16_000_000
PINS = {"AccelStepper": (2, 5), "FastAccelStepper": (9, 5)}  # STEP, DIR


def need() -> None:
    """Skip the test where something is missing; in CI that is a failure."""
    gone = [name for name in NEEDED if shutil.which(name) is None]
    gone += [] if CORE.exists() else ["arduino-core-avr"]
    gone += [] if AVR8JS.exists() else ["avr8js"]
    if gone:
        reason = f"{', '.join(gone)}: not installed; this does it:  make boards"
        (pytest.fail if os.environ.get("CI") else pytest.skip)(reason)


def called(*words: str | Path) -> None:
    """Run a compiler.

    Raises:
        AssertionError: it complains.
    """
    ran = subprocess.run([str(word) for word in words], capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stderr


def build_core(folder: Path) -> list[Path]:
    """Compile Arduino's core; return its objects."""
    objects = []
    for source in sorted((CORE / "cores" / "arduino").iterdir()):
        how = {".c": ("avr-gcc", "-std=gnu11"), ".cpp": ("avr-g++", *CPP)}.get(source.suffix)
        if how:
            objects.append(folder / f"{source.name}.o")
            called(how[0], *WORDS, "-w", *how[1:], "-c", source, "-o", objects[-1])
    return objects


def build(text: str, core: list[Path], folder: Path) -> Path:
    """Compile a sketch, without any warning; return its .hex."""
    sketch, elf, out = folder / "sketch.cpp", folder / "sketch.elf", folder / "sketch.hex"
    sketch.write_text(f"#include <Arduino.h>\n{text}", encoding="utf-8")
    includes = (f"-I{HERE / 'arduino'}",)
    called("avr-g++", *WORDS, *CPP, *includes, "-Wall", "-Werror", "-c", sketch, "-o", folder / "sketch.o")
    called("avr-gcc", "-mmcu=atmega328p", "-Os", "-Wl,--gc-sections", "-o", elf, folder / "sketch.o", *core, "-lm")
    called("avr-objcopy", "-O", "ihex", "-R", ".eeprom", elf, out)
    return out


class Seen(NamedTuple):
    """What the pins of an Uno did: steps with their signs and times, s; levels of other pins with their times, s."""

    steps: list[int]
    times: list[float]
    levels: list[tuple[float, int, int]]


def run(hexadecimal: Path, pins: tuple[int, int], until: float, inputs: list[list[Any]], idle: float = 1.0) -> Seen:
    """Run a sketch for some virtual seconds, or until no output has changed for some."""
    request = {"until": until, "idle": idle, "inputs": inputs}
    words = ["node", str(HERE / "uno.js"), str(AVR8JS), str(hexadecimal)]
    ran = subprocess.run(words, input=json.dumps(request), capture_output=True, text=True, check=True, timeout=120)
    answer = json.loads(ran.stdout)
    step, direction = pins
    seen, sign = Seen([], [], []), -1
    for cycle, pin, level in answer["changes"]:
        if pin == direction:
            sign = 1 if level else -1
        elif pin == step:
            if level:
                seen.steps.append(sign)
                seen.times.append(cycle / HZ)
        else:
            seen.levels.append((cycle / HZ, pin, level))
    return seen
