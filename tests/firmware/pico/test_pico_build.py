"""The file for a Pico: the same bytes wherever it is built, whole, small enough, and clear of the stored program."""

from __future__ import annotations

import re
import struct
import zlib
from pathlib import Path

import pytest

from tools import pico as tool

from . import needs

pytestmark = pytest.mark.system
SIZES = (Path(tool.SOURCES) / "sizes.h").read_text("ascii")


def blocks(data: bytes) -> list[tuple[int, bytes]]:
    """Check the blocks of a .uf2 file; return address and content of each."""
    assert len(data) % 512 == 0
    out = []
    for number in range(len(data) // 512):
        block = data[number * 512 : number * 512 + 512]
        first, second, flags, address, size, index, count, family = struct.unpack_from("<8I", block)
        assert (first, second, flags, size, family) == (0x0A324655, 0x9E5D5157, 0x2000, 256, 0xE48BFF56)
        assert (index, count) == (number, len(data) // 512)
        assert struct.unpack_from("<I", block, 508) == (0x0AB16F30,)
        out.append((address, block[32 : 32 + 256]))
    return out


def test_the_same_file_comes_of_two_folders(pico, tmp_path: Path) -> None:
    again = tool.build(tmp_path / "another name" / "deeper")
    assert again.path.read_bytes() == pico.path.read_bytes()
    assert str(tmp_path).encode() not in again.path.read_bytes()


def test_each_part_has_a_file_with_its_name(pico, tmp_path: Path) -> None:
    other = tool.build(tmp_path, part="gs-c200")
    assert [made.path.name for made in (pico, other)] == ["slewline-gs-c200s.uf2", "slewline-gs-c200.uf2"]
    assert tool.version("gs-c200").encode() in other.image.read_bytes()
    assert abs(other.flash - pico.flash) < 64  # the same but for a number and a name


def test_the_file_is_the_image_and_its_checksums_fit(pico) -> None:
    found, image = blocks(pico.path.read_bytes()), pico.image.read_bytes()
    assert [address for address, _ in found] == [0x10000000 + 256 * n for n in range(len(found))]
    assert b"".join(data for _, data in found)[: len(image)] == image
    assert struct.unpack_from("<I", image, 252)[0] == tool.boot_checksum(image[:252])
    magic, length, crc = struct.unpack_from("<III", image, 256 + 8)
    assert magic == 0x32435347
    stored = pico.symbols["image_stored"] - 0x10000000
    assert length == len(image) - stored == pico.code
    assert crc == zlib.crc32(image[stored:])
    assert tool.version().encode() in image


def test_the_checksum_of_the_boot_rom_is_that_of_mpeg2() -> None:
    assert tool.boot_checksum(b"123456789") == 0x0376E6E7  # the check value of CRC-32/MPEG-2


def test_it_leaves_room_and_an_update_does_not_reach_the_program(pico) -> None:
    assert pico.flash < tool.FLASH
    assert pico.ram + 2048 < tool.RAM
    stores = [int(text, 16) for text in re.findall(r"#define STORE_[AB] (0x[0-9A-F]+)u", SIZES)]
    assert len(stores) == 2
    assert all(address - 0x10000000 + 256 <= min(stores) for address, _ in blocks(pico.path.read_bytes()))


def test_boot2_that_is_too_long_is_refused() -> None:
    needs.need()
    with pytest.raises(tool.PicoError, match=r"boot2\.S takes more than 252 bytes"):
        tool.finished(b"\1" * 400, 300)
