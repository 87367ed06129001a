"""Pictures as files: PNG, SVG and PDF, the same bytes every time; an SVG tells a screen reader what it shows."""

from __future__ import annotations

from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any
from xml.sax.saxutils import escape

from ..errors import UsageError
from .style import DPI, styled
from .whole_file import WholeFile

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SUFFIXES = (".svg", ".png", ".pdf")
QUICK: dict[str, Any] = {"png": {"pil_kwargs": {"compress_level": 3}}}  # a tenth more bytes


def check_suffix(path: str | Path) -> None:
    """Check that a picture can be written under this name.

    Raises:
        UsageError: its suffix is none of ours.
    """
    if Path(path).suffix.lower() not in SUFFIXES:
        raise UsageError(f"{path}: allowed are file names ending in {', '.join(SUFFIXES[:-1])} or {SUFFIXES[-1]}")


def save(figure: Figure, path: str | Path, title: str, description: str, dark: bool = False) -> None:
    """Write a figure into a file; its suffix says in which form, and an existing file is replaced whole or not at all.

    Args:
        title: what the picture is called, as metadata (and to a screen reader, in an SVG).
        description: a sentence or two on what it shows, for those who cannot see it.

    Raises:
        UsageError: an unknown suffix, or a path that cannot be written.
    """
    check_suffix(path)
    kind = Path(path).suffix.lower()[1:]
    metadata: dict[str, dict[str, Any]] = {
        "svg": {"Title": title, "Date": None, "Creator": "slewline"},
        "png": {"Title": title, "Description": description, "Software": "slewline"},
        "pdf": {"Title": title, "Subject": description, "Creator": "slewline", "CreationDate": None},
    }
    with WholeFile(path) as file, styled(dark):
        buffer = BytesIO()
        figure.savefig(buffer, format=kind, dpi=DPI, metadata=metadata[kind], **QUICK.get(kind, {}))
        data = buffer.getvalue()
        file.write(_told(data, description) if kind == "svg" else data)


def _told(svg: bytes, description: str) -> bytes:
    """An SVG that a screen reader takes for one picture, with its description."""
    svg = svg.replace(b"<svg ", b'<svg role="img" ', 1)
    return svg.replace(b"</title>", b"</title>\n <desc>" + escape(description).encode() + b"</desc>", 1)
