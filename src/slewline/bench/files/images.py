"""Memory images in files: binary dumps or Intel HEX, as selected by the file extension."""

from __future__ import annotations

from os import PathLike
from os.path import isfile
from pathlib import Path
from typing import Any

from ...chips import CATALOGUE
from ...core.memory.image import LARGEST, check_text, from_file, from_hex, named_file, to_hex
from ...core.messages.calls import answering
from ...errors import BenchFileError, UsageError
from ...gate import BOM, read_file
from .hex_text import hex_text, is_named_hex


@answering("read_image()")
def read_image(path: str | PathLike[str]) -> bytes:
    """Return the memory image in a file, starting at address 0.

    Args:
        path: the file; Intel HEX if its name ends in .hex, .ihx or .ihex, else a binary dump.

    Raises:
        BenchFileError: the file cannot be read, is longer than 64K bytes, or has a line that is not Intel HEX.
    """
    data, where = read_file(path), str(path)
    if Path(path).suffix[1:].lower() in CATALOGUE.names():
        raise BenchFileError(
            f"{path}: a program, judging by its extension; slewline asm --output F.ihx makes an image of it"
        )
    if not is_named_hex(path):
        marked = data[len(BOM) :].lstrip()[:1] == b":"  # a text; a dump may begin with the same bytes as a mark
        return from_file(data.removeprefix(BOM) if marked else data, where)
    return from_hex(hex_text(data, where), where)


def image_given(owner: str, image: Any) -> Any:
    """Return an image passed to a part: for a `Path`, the content of the file; anything else is returned unchanged.

    Raises:
        UsageError: `image` is text that names a file; the name itself would be taken for the content.
        BenchFileError: the file cannot be read.
    """
    if isinstance(image, PathLike):
        return read_image(image)
    check_text(owner, image)
    if isinstance(image, str) and isfile(image):
        raise named_file(owner, image)
    return image


def as_image_file(path: str | PathLike[str], image: bytes) -> bytes:
    """Return the file content for an image: Intel HEX if `path` has its extension, else the bytes themselves."""
    return to_hex(image).encode("ascii") if is_named_hex(path) else image


@answering("write_image()")
def write_image(path: str | PathLike[str], image: bytes) -> None:
    """Write a memory image to a file, completely or not at all.

    Args:
        path: the file; Intel HEX if its name ends in .hex, .ihx or .ihex, else a binary dump.
        image: the bytes, starting at address 0.

    Raises:
        UsageError: the file cannot be written, or `image` is not bytes, or is longer than 64K bytes.
    """
    from ...record.whole_file import WholeFile

    if not isinstance(image, (bytes, bytearray)):
        raise UsageError(f"{path}: image {image!r}; expected bytes, such as the result of read_image()")
    if len(image) > LARGEST:
        raise UsageError(f"{path}: an image of {len(image)} bytes; allowed up to {LARGEST} (sixteen address lines)")
    with WholeFile(str(path)) as file:
        file.write(as_image_file(path, image))
