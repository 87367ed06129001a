"""The options of pictures, each with its type and default; `bench.figure` and `bench.timing` describe them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Protocol, TypedDict

if TYPE_CHECKING:
    from ...core.motion.axis import Steps
    from ...core.time.timebase import Time
    from ...record.recording.traces import Trace
    from .window import Between

    class Bench(Protocol):
        """The members of a bench that a picture needs.

        The bench class itself cannot be imported here, because its module imports this folder.
        """

        _pictures: Any


class PictureOptions(TypedDict, total=False):
    """The options of `bench.figure` and `bench.plot` other than the title, the pins and the window."""

    axes: Sequence[int | str] | int | str | None
    parts: Sequence[str] | str | None
    runs: Mapping[str, Bench | Steps] | None
    over: Mapping[str, Trace] | None
    ideal: bool
    cursors: Time | Iterable[Time]
    dark: bool
    width: str | float
    marks: bool


class Picture(PictureOptions, total=False):
    """All options of a picture."""

    title: str | None
    pins: Sequence[str | Trace] | None
    start: Time | None
    stop: Time | None


PICTURE = Picture(
    title=None, pins=None, start=None, stop=None, axes=None, parts=None, runs=None, over=None,
    ideal=False, cursors=(), dark=False, width="page", marks=True,
)  # fmt: skip


class DiagramOptions(TypedDict, total=False):
    """The options of `bench.timing` and `bench.timing_figure` other than the pins and the window."""

    between: Iterable[Between]
    causes: Iterable[tuple[str, str]]
    title: str | None
    over: Mapping[str, Trace] | None
    names: Mapping[str, str] | None
    decode: bool
    quiet: Time | None
    width: str | float
    dark: bool


DIAGRAM = DiagramOptions(
    between=(), causes=(), title=None, over=None, names=None, decode=False, quiet=None, width="page", dark=False
)
