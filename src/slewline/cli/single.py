"""The bench of a command: from a file, or with a single chip, its host, and optionally a program."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ..chips import sheet_of

if TYPE_CHECKING:
    from ..bench import Bench
    from ..bench.file import BenchFile
    from ..bench.scripts.script_runner import Script
    from ..core.datasheet.table import Sheet


@dataclass
class BenchOptions:
    """The options for a bench.

    `chip` and `strap` apply if there is no bench file.  `anywhere` and `allow_code` are the permissions that
    the user gives to a bench file.
    """

    chip: str | None
    strap: tuple[tuple[str, int], ...]
    anywhere: bool
    allow_code: bool

    def bench_file(self, path: str) -> BenchFile:
        """Read and return a bench file."""
        from ..bench.file import BenchFile

        return BenchFile(path, self.anywhere, self.allow_code)


def single(
    part: str,
    program: tuple[str, str] | None = None,
    *,
    crystal: str | None = None,
    strap: Mapping[str, int] | None = None,
    options: Mapping[str, Any] | None = None,
    memory: str | None = None,
    over: str | None = None,
    journal: str | None = None,
    prepare: Callable[[Bench], object] = lambda _bench: None,
) -> Bench:
    """Return a bench with a chip and a host; a program, if given, is queued on the host.

    Args:
        program: the text, and the name of its file; None leaves the host idle.
        strap: levels of inputs; all other inputs get levels that suit a program without address and
            checksum.
        options: the options of the chip.
        memory: a file with an image of the chip's memory.
        over: the channel that the host uses, if the chip has several.
        journal: the file that records every external input; None for no journal.
        prepare: a function that is called with the bench before the program is queued.

    Raises:
        ProgramError: a line of the program cannot be played.
    """
    from ..bench import Bench
    from ..bench.memories import put_memory
    from ..bench.scripts.script import check_script, run_script

    sheet = sheet_of(part)
    script, straps = (None, sheet.fastest | sheet.plain) if program is None else read(*program, sheet)
    bench = Bench(journal=journal)
    chip = bench.add(part, crystal=crystal, straps=straps | dict(strap or {}), **(options or {}))
    put_memory(bench, chip, memory)
    host = bench.host(chip, over=over)
    if script is not None:
        check_script(bench, host, script)
    prepare(bench)
    if script is not None:
        run_script(bench, host, script)
    return bench


def read(text: str, file: str, sheet: Sheet) -> tuple[Script, dict[str, int]]:
    """Return the script of a program file, and the straps that it needs.

    The bytes of a .hex file go to a chip in binary mode or, as separate packets, to a chipset; a module on a
    serial line is strapped for its highest rate and for lines without checksums.
    """
    from ..bench.files.hex_text import is_named_hex
    from ..bench.scripts.program_file import program_script

    script, straps = program_script(text, file, sheet), sheet.fastest | sheet.plain
    mode = sheet.role("text") if is_named_hex(file) else None
    return script, straps | ({mode.name: 0} if mode is not None else {})
