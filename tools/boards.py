"""Install the tools that build and test the firmware of boards: tools/boards.py [FOLDER].

The compilers come from packages of the system (.ci/install), the emulators with npm into FOLDER (build/boards); then
the firmware is built there.  Existing files are kept.  If the compiler for ARM is not available, only the Uno's
firmware is built.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pico

from firmware import FirmwareError, build, report

ROOT = Path(__file__).resolve().parent.parent
EMULATORS = {"avr8js": "0.21.1", "rp2040js": "1.4.1"}
TRUSTED = Path("/etc/ssl/certs/ca-certificates.crt")  # by the system, of which npm knows nothing
# Their programs, or for avr-libc, which has none, a file of it: the compiler does not bring it along.
PACKAGES = (
    "avr-gcc=gcc-avr",
    "gcc=gcc",
    "/usr/include/stdio.h=libc6-dev",
    "avr-objcopy=binutils-avr",
    "/usr/lib/avr/include/avr/io.h=avr-libc",
    "/usr/share/arduino/hardware/arduino/avr/cores/arduino/Arduino.h=arduino-core-avr",  # for sketches, in tests
    "node=nodejs",
    "npm",
)
OF_THE_PICO = ("arm-none-eabi-gcc=gcc-arm-none-eabi", f"{pico.LIBRARY}=picolibc-arm-none-eabi")


def is_here(place: Path) -> bool:
    """Return whether a folder has exactly these versions of the emulators."""
    abouts = {place / "node_modules" / name / "package.json": version for name, version in EMULATORS.items()}
    return all(
        about.exists() and json.loads(about.read_text())["version"] == version for about, version in abouts.items()
    )


def fetch(place: Path) -> int:
    """Install the emulators with npm, only into the folder."""
    place.mkdir(parents=True, exist_ok=True)
    words = ["install", "--prefix", str(place), "--no-save", "--no-package-lock", "--ignore-scripts"]
    words += ["--no-audit", "--no-fund", "--silent", *(f"{name}@{version}" for name, version in EMULATORS.items())]
    trusted = {"NODE_EXTRA_CA_CERTS": str(TRUSTED)} if TRUSTED.exists() else {}
    return subprocess.call([str(shutil.which("npm")), *words], cwd=place, env=trusted | os.environ)


def main(words: list[str]) -> int:
    """Install, build, and print the result."""
    place = Path(words[0]).resolve() if words else ROOT / "build" / "boards"
    if subprocess.call([str(ROOT / ".ci" / "install"), *PACKAGES], cwd=ROOT) != 0:
        return 1
    if not is_here(place) and fetch(place) != 0:
        print(f"boards: npm could not install {' and '.join(EMULATORS)}; the reason is above", file=sys.stderr)
        return 1
    try:
        print(report(build(place.parent / "firmware")))
        if subprocess.call([str(ROOT / ".ci" / "install"), *OF_THE_PICO], cwd=ROOT) == 0:
            for part in pico.PARTS:
                print(pico.report(pico.build(place.parent / "firmware", part=part)))
    except (FirmwareError, pico.PicoError) as error:
        print(f"boards: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
