"""The bench: the one place that joins chips, parts and recorders."""

from .bench import Bench
from .replaying import replay

__all__ = ["Bench", "load", "replay"]


def load(path: str, *, anywhere: bool = False, **options: object) -> Bench:
    """Return the bench that a bench file (TOML) describes, with chips, parts and wires, its scripts queued.

    Args:
        path: the file.
        anywhere: let the file name files outside its own folder.
        options: of the bench, such as journal="run.jsonl".

    Raises:
        BenchFileError: the file cannot be read or does not make a bench; file, line and key are in the message.
        ProgramError: a script has lines that cannot be played.
    """
    from .file import load_bench

    return load_bench(path, anywhere=anywhere, **options)
