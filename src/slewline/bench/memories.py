"""The external program memory of a chip, for benches on which the user has not placed one."""

from __future__ import annotations

from os import PathLike
from typing import TYPE_CHECKING, Any

from ..errors import UsageError
from .files.images import read_image

if TYPE_CHECKING:
    from ..core.chip import Chip
    from ..core.datasheet.table import Sheet
    from ..core.memory.store import Store
    from .bench import Bench

NAME = "memory"


def is_outside(sheet: Sheet) -> bool:
    """Return whether a part stores its programs in an external memory on a separate bus."""
    return sheet.role("memory_select") is not None


def put_memory(
    bench: Bench, chip: Chip, image: str | PathLike[str] | None = None, *, store: Store | None = None
) -> Any:
    """Put the external memory of a chip on the bench: 64K bytes of RAM, or of EEPROM if there is a store.

    Args:
        image: a file, binary dump or Intel HEX, that is loaded into the memory even if the store has content.
        store: the non-volatile store of the memory; by default the one that the bench's `stores` returns, if set.

    Returns:
        The memory, a part; None if the chip has no external memory.

    Raises:
        UsageError: an image is given, but the chip has no external memory.
        BenchFileError: the image cannot be read.
    """
    if not is_outside(chip.sheet):
        if image is not None:
            raise UsageError(f"memory {image}: a {chip.sheet.part} has no external memory; leave out this file")
        return None
    data = b"" if image is None else read_image(image)
    kept = store is not None or bench.stores is not None
    options: dict[str, Any] = {} if store is None else {"store": store}
    memory: Any = bench.part("eeprom" if kept else "ram", name=NAME, to=chip, image=data, **options)
    if kept and data and memory.content[: len(data)] != data:
        memory.load(data)
    return memory
