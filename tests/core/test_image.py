"""Images of memories: a dump or Intel HEX, there and back, and what is wrong with a file is told with its place."""

from __future__ import annotations

from random import Random

import pytest

from slewline.bench.files.images import read_image, write_image
from slewline.core.memory.image import LARGEST, SIZES, from_file, from_hex, is_hex, size_of, to_hex
from slewline.errors import BenchFileError, UsageError
from tests.rows import rows

PRINTED = """\
:10010000214601360121470136007EFE09D2190140
:100110002146017E17C20001FF5F16002148011928
:00000001FF
"""  # an example of the format, as it is printed everywhere


def test_a_printed_example_is_read() -> None:
    image = from_hex(PRINTED, "x.hex")
    assert image[:0x100] == b"\xff" * 0x100
    assert image[0x100:0x110].hex().upper() == "214601360121470136007EFE09D21901"
    assert len(image) == 0x120


@rows("size", [0, 1, 15, 16, 17, 255, 2048, 32768, LARGEST])
def test_an_image_comes_back_from_intel_hex(size: int) -> None:
    image = Random(size).randbytes(size)
    assert from_hex(to_hex(image), "x.hex") == image


def test_erased_rows_are_left_out_but_not_the_length() -> None:
    image = b"N 1\r".ljust(32768, b"\xff")
    text = to_hex(image)
    assert len(text.splitlines()) == 3
    assert from_hex(text, "x.hex") == image and size_of(from_hex(text, "x.hex")) == 32768


def test_another_program_reads_what_we_write() -> None:
    """The checksums and lengths by a formula of their own."""
    for line in to_hex(Random(3).randbytes(100)).splitlines():
        record = bytes.fromhex(line[1:])
        assert line[0] == ":" and sum(record) % 256 == 0 and record[0] == len(record) - 5


def test_lower_case_blank_lines_and_start_addresses_are_taken() -> None:
    text = PRINTED.lower().replace(":00000001ff", "\n:0400000300003800c1\n:0400000500000000f7\n:00000001ff")
    assert from_hex(text, "x.hex") == from_hex(PRINTED, "x.hex")
    assert from_hex(PRINTED.replace("\n", "\r\n"), "x.hex") == from_hex(PRINTED, "x.hex")


@pytest.mark.parametrize(("base", "address"), [(":020000020800F4", 0x8000), (":020000040000FA", 0)])
def test_a_base_moves_the_addresses_after_it(base: str, address: int) -> None:
    image = from_hex(f"{base}\n:0100100041AE\n:00000001FF\n", "x.hex")
    assert image[address + 0x10] == 0x41 and len(image) == address + 0x11


def test_an_address_is_added_to_the_base_with_its_carry() -> None:
    image = from_hex(":020000020018E4\n:01018000413D\n:00000001FF\n", "x.hex")
    assert image[0x180 + 0x180] == 0x41 and len(image) == 0x301


@rows(
    ("text", "says"),
    [
        (PRINTED.replace(":00000001FF\n", ""), r"no end record \(type 01\)"),
        (PRINTED.replace("D2190140", "D2190141"), "line 1: checksum 41, calculated 40"),
        (PRINTED.replace("1928", "28"), "line 2: 15 bytes of data, but the count is 16"),
        ("hello\n", "line 1: 'hello' is not a record"),
        (":0G\n", "line 1: ':0G' is not a record"),
        (":00000009F7\n", "line 1: a record of type 09; allowed 00 to 05"),
        (":020000040001F9\n:0100000041BE\n:00000001FF\n", "line 2: the data end at address 10000; allowed up to FFFF"),
        (":0100000041BE\n:0100000042BD\n:00000001FF\n", "line 2: address 0000 is 42 here and 41 above"),
        (":0100000000FF\n:01000002FFFE\n", "line 2: a base address of 1 bytes; required 2"),
    ],
)
def test_mistakes_are_reported_with_their_line(text: str, says: str) -> None:
    with pytest.raises(BenchFileError, match=f"x.hex.*{says}"):
        from_hex(text, "x.hex")


def test_a_file_declares_its_own_format() -> None:
    assert is_hex(PRINTED.encode()) and not is_hex(b"") and not is_hex(b": hello") and not is_hex(b"N 1\r")
    assert from_file(b"N 1\r", "x.bin") == b"N 1\r"
    with pytest.raises(BenchFileError, match=r"x.bin: an image of 65537 bytes; allowed up to 65536"):
        from_file(bytes(LARGEST + 1), "x.bin")


def test_a_dump_is_taken_for_the_part_that_is_as_long() -> None:
    assert [size_of(bytes(size)) for size in SIZES] == list(SIZES)
    assert size_of(b"") == size_of(bytes(100)) == size_of(bytes(32767)) == LARGEST


@pytest.mark.parametrize("name", ["x.bin", "x.hex", "x.HEX", "x.ihx"])
def test_the_name_of_a_file_determines_its_format(name: str, tmp_path) -> None:
    image = Random(1).randbytes(300)
    write_image(tmp_path / name, image)
    assert read_image(tmp_path / name) == image
    assert ((tmp_path / name).read_bytes() == image) is name.endswith(".bin")


def test_a_file_that_is_called_hex_is_read_as_such(tmp_path) -> None:
    (tmp_path / "x.hex").write_bytes(b"N 1\r")
    with pytest.raises(BenchFileError, match=r"x\.hex, line 1: 'N 1' is not a record"):
        read_image(tmp_path / "x.hex")
    with pytest.raises(BenchFileError, match=r"y\.hex cannot be read: No such file"):
        read_image(tmp_path / "y.hex")
    with pytest.raises(UsageError, match="there is no directory"):
        write_image(tmp_path / "none" / "x.hex", b"")


@pytest.mark.parametrize(
    ("image", "says"), [(bytes(LARGEST + 1), "an image of 65537 bytes; allowed up to 65536"), ("abc", "expected bytes")]
)
def test_an_invalid_image_is_not_written(image, says: str, tmp_path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(UsageError, match=says):
        write_image("x.hex", image)
    assert not list(tmp_path.iterdir())
