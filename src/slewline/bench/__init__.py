"""The bench: the one place that joins chips, parts and recorders."""

from .bench import Bench
from .journal import replay

__all__ = ["Bench", "load", "replay"]


def load(path: str, **options: object) -> Bench:
    """A bench from a bench file (TOML)."""
    from .file import load_bench

    return load_bench(path, **options)
