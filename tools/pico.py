"""Build the firmware of a GS-C200S and of a GS-C200 for a Raspberry Pi Pico: tools/pico.py [FOLDER].

The default folder is build/firmware.

The .uf2 is the same byte for byte wherever it is built: sources in the order of their names, no paths or dates in it.
Compiler and library come with the packages of the system: gcc-arm-none-eabi, picolibc-arm-none-eabi.
"""

from __future__ import annotations

import re
import shutil
import struct
import subprocess
import sys
import zlib
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parent.parent
SOURCES = ROOT / "firmware" / "pico"
CORE = ROOT / "firmware" / "part" / "gs_c200"
PARTS = {"gs-c200s": "GSC_C200S", "gs-c200": "GSC_C200"}  # as gsc200.h names them
LIBRARY = Path("/usr/lib/picolibc/arm-none-eabi/picolibc.specs")
NEEDED = ("arm-none-eabi-gcc", "arm-none-eabi-objcopy", "arm-none-eabi-nm", "arm-none-eabi-size")
WORDS = (
    "-mcpu=cortex-m0plus",
    "-mthumb",
    "-masm-syntax-unified",
    "-std=c11",
    "-O2",
    "-Wall",
    "-Wextra",
    "-Wconversion",
    "-Wshadow",
    "-Werror",
    "-ffunction-sections",
    "-fdata-sections",
    "-ffreestanding",
    "-fno-tree-loop-distribute-patterns",  # memcpy is not made of calls of memcpy
    "-fno-common",
    f"--specs={LIBRARY}",
    "-nostartfiles",
)
FLASH, RAM, STACK = 64 * 1024, 16 * 1024, 2 * 1024  # bytes that it may take; RAM without the code that is copied there
FLASH_BEGIN, BOOT2, PAGE = 0x10000000, 256, 256
HEADER = 8  # where its header is, from the end of the second stage on: after two vectors
UF2 = (0x0A324655, 0x9E5D5157, 0x0AB16F30)
FAMILY = 0xE48BFF56  # of the RP2040


class PicoError(Exception):
    """A missing program, or the error message of the compiler."""


class PicoFirmware(NamedTuple):
    """The result of a build: files, bytes of flash, of RAM for code and for data, and symbol addresses by name."""

    path: Path
    image: Path
    flash: int
    code: int
    ram: int
    symbols: dict[str, int]


def missing() -> list[str]:
    """Return the missing programs and files."""
    gone = [name for name in NEEDED if shutil.which(name) is None]
    return gone + ([] if LIBRARY.exists() else ["picolibc"])


def called(*words: str | Path) -> str:
    """Return the output of a program."""
    ran = subprocess.run([str(word) for word in words], cwd=SOURCES, capture_output=True, text=True, check=False)
    if ran.returncode:
        raise PicoError(f"{words[0]} ended with {ran.returncode}:\n{ran.stderr}")
    return ran.stdout


def boot_checksum(data: bytes) -> int:
    """Return the CRC-32 that the boot ROM expects: polynomial 04C11DB7, highest bit first, not inverted at the end."""
    crc = 0xFFFFFFFF
    for byte in data:
        crc ^= byte << 24
        for _ in range(8):
            crc = (crc << 1 ^ (0x04C11DB7 if crc >> 31 else 0)) & 0xFFFFFFFF
    return crc


def finished(image: bytes, stored: int) -> bytes:
    """Return an image with its checksums: of the second stage, and of the code that runs in RAM, from `stored` on."""
    whole = bytearray(image)
    if any(whole[BOOT2 - 4 : BOOT2]):
        raise PicoError(f"boot2.S takes more than {BOOT2 - 4} bytes")
    whole[BOOT2 - 4 : BOOT2] = struct.pack("<I", boot_checksum(bytes(whole[: BOOT2 - 4])))
    run = bytes(whole[stored:])
    struct.pack_into("<II", whole, BOOT2 + HEADER + 4, len(run), zlib.crc32(run))
    return bytes(whole)


def uf2(image: bytes) -> bytes:
    """Return the file to copy to the drive of a Pico: blocks of 512 bytes for each 256 of flash."""
    pages = [image[at : at + PAGE].ljust(PAGE, b"\0") for at in range(0, len(image), PAGE)]
    blocks = []
    for number, page in enumerate(pages):
        head = struct.pack("<8I", UF2[0], UF2[1], 0x2000, FLASH_BEGIN + number * PAGE, PAGE, number, len(pages), FAMILY)
        blocks.append((head + page).ljust(508, b"\0") + struct.pack("<I", UF2[2]))
    return b"".join(blocks)


def version(part: str = "gs-c200s") -> str:
    """Return the answer of the board of a part to ENQ."""
    found = re.search(r'^__version__ = "(.+)"', (ROOT / "src" / "slewline" / "version.py").read_text("utf-8"), re.M)
    if found is None:
        raise PicoError("src/slewline/version.py: no version in it")
    return f"slewline {part} pico {found[1]}"


def build(folder: Path, *more: str, part: str = "gs-c200s") -> PicoFirmware:
    """Build the firmware of a part into a folder; `more` are arguments for the compiler.

    Raises:
        PicoError: the compiler is missing, or reports an error.
    """
    if gone := missing():
        raise PicoError(
            f"{', '.join(gone)}: not installed; on Debian:  apt install gcc-arm-none-eabi picolibc-arm-none-eabi"
        )
    folder = folder.resolve()
    parts = folder / part
    parts.mkdir(parents=True, exist_ok=True)
    objects = []
    words = (*WORDS, f"-DPART={PARTS[part]}", f'-DVERSION_TEXT="{version(part)}"', "-I../part/gs_c200", *more)
    for where, prefix in ((SOURCES, "pico"), (CORE, "part")):
        for source in sorted(path for path in where.iterdir() if path.suffix in (".c", ".S")):
            objects.append(parts / f"{prefix}-{source.name}.o")
            place = source.name if where is SOURCES else f"../part/gs_c200/{source.name}"
            called("arm-none-eabi-gcc", *words, "-c", place, "-o", objects[-1])
    elf, raw = parts / "pico.elf", parts / "pico.bin"
    called("arm-none-eabi-gcc", *words, "-Wl,--gc-sections", "-Tpico.ld", "-o", elf, *objects)
    called("arm-none-eabi-objcopy", "-O", "binary", elf, raw)
    symbols = {
        line.split()[2]: int(line.split()[0], 16)
        for line in called("arm-none-eabi-nm", "--defined-only", elf).splitlines()
    }
    image = finished(raw.read_bytes(), symbols["image_stored"] - FLASH_BEGIN)
    raw.write_bytes(image)
    file = folder / f"slewline-{part}.uf2"
    file.write_bytes(uf2(image))
    code = symbols["image_end"] - symbols["image_begin"]
    return PicoFirmware(file, raw, len(image), code, symbols["bss_end"] - symbols["bss_begin"], symbols)


def report(made: PicoFirmware) -> str:
    """Return a line with the name and the size of a build."""
    return (
        f"{made.path}: {made.flash} of {FLASH} bytes of flash, "
        f"{made.ram} of {RAM} bytes of RAM besides the {made.code} that are copied there to run"
    )


def main(words: list[str]) -> int:
    """Build the firmware, and print its size; return the exit status."""
    try:
        for part in PARTS:
            print(report(build(Path(words[0]) if words else ROOT / "build" / "firmware", part=part)))
    except PicoError as error:
        print(f"pico: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
