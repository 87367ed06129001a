"""The bench, which joins chips, parts and recorders."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ..core.messages.calls import answering
from ..lazy import lazily
from .bench import Bench

if TYPE_CHECKING:
    from .replaying import replay

__all__ = ["Bench", "load", "replay"]


@answering("load()")
def load(path: str, *, anywhere: bool = False, allow_code: bool = False, **options: Any) -> Bench:
    """Return the bench that a bench file (TOML) describes, with its chips, parts and wires; its scripts are queued.

    Args:
        path: the bench file.
        anywhere: allow the bench file to name files and links outside its own folder, and any device.
        allow_code: allow it to name chips and parts as module:Class; importing them runs code from the module.
        options: options of `Bench`, such as journal="run.jsonl".

    Raises:
        BenchFileError: the file cannot be read, or does not describe a bench; the message states file, line and key.
        ProgramError: a script has lines that cannot be executed.
    """
    from .file import BenchFile

    return BenchFile(path, anywhere, allow_code).load(**options)


__getattr__, __dir__ = lazily(globals(), {"bench.replaying": ("replay",)})
