"""Pictures as files: PNG, SVG and PDF, always with the same bytes; an SVG has a description for screen readers."""

from __future__ import annotations

import sys
from html import escape  # the one in xml.sax loads code that can fetch documents from the network
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...errors import UsageError
from ..style import DPI, styled
from ..whole_file import WholeFile, check_suffix
from .svg import compact

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SUFFIXES = (".svg", ".png", ".pdf")
QUICK: dict[str, Any] = {"png": {"pil_kwargs": {"compress_level": 3}}}  # a tenth more bytes than the best level


def save(figure: Figure, path: str | Path, title: str, description: str, dark: bool = False) -> None:
    """Write a figure to a file in the format of its suffix; replace an existing file completely or not at all.

    Args:
        title: the title of the picture, as metadata (and for a screen reader, in an SVG).
        description: a sentence or two that describe the picture, for readers who cannot see it.

    Raises:
        UsageError: an unknown suffix, or a path that cannot be written.
    """
    check_suffix(path, SUFFIXES)
    with WholeFile(path) as file:
        file.write(drawn(figure, Path(path).suffix.lower()[1:], title, description, dark))


def drawn(figure: Figure, kind: str, title: str, description: str, dark: bool = False) -> bytes:
    """Return a figure as the bytes of a file; all arguments except `kind` are those of `save`.

    Args:
        kind: "svg", "png" or "pdf".
    """
    metadata: dict[str, dict[str, Any]] = {
        "svg": {"Title": title, "Date": None, "Creator": "slewline"},
        "png": {"Title": title, "Description": description, "Software": "slewline"},
        "pdf": {"Title": title, "Subject": description, "Creator": "slewline", "CreationDate": None},
    }
    buffer = BytesIO()
    with styled(dark):
        figure.savefig(buffer, format=kind, dpi=DPI, metadata=metadata[kind], **QUICK.get(kind, {}))
    data = buffer.getvalue()
    return compact(_described(data, description)) if kind == "svg" else data


def show(figure: Figure) -> None:
    """Show a figure in the current notebook; without one, in a window, and wait until that is closed.

    Raises:
        UsageError: matplotlib cannot open a window, for example because there is no screen.
    """
    shell = sys.modules["IPython"].get_ipython() if "IPython" in sys.modules else None
    if hasattr(shell, "kernel"):
        from IPython.display import display  # type: ignore[import-not-found, unused-ignore]

        display(figure)  # type: ignore[no-untyped-call, unused-ignore]
        return
    import matplotlib.pyplot as plt

    remedy = "bench.plot('run.svg') draws into a file"
    try:
        if plt.get_backend().lower() in ("agg", "cairo", "pdf", "pgf", "ps", "svg", "template"):
            raise ImportError(f"the backend {plt.get_backend()} has no windows")
        plt.figure(FigureClass=lambda *_, **__: figure)  # type: ignore[arg-type]
    except ImportError as error:
        raise UsageError(f"show: matplotlib cannot open a window: {error}; {remedy}") from None
    plt.show()


def _described(svg: bytes, description: str) -> bytes:
    """Return an SVG with a description added, marked so that a screen reader treats it as one picture."""
    svg = svg.replace(b"<svg ", b'<svg role="img" ', 1)
    return svg.replace(b"</title>", b"</title>\n <desc>" + escape(description, quote=False).encode() + b"</desc>", 1)
