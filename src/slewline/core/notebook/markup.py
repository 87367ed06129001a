"""HTML and SVG elements, and the card that a notebook shows; the text in them is escaped.

    element("td", "a < b", class_="name")      <td class="name">a &lt; b</td>

Only results of `element` are included without escaping, because a journal, a program or a data sheet may
come from an untrusted source.  A card has no scripts and loads nothing.  It uses the text colour of the
page, which may be light or dark, and two colours that are visible on light and dark pages.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape

HIGH, ACCENT = "#c47d0e", "#14958a"
MONO = "ui-monospace, 'DejaVu Sans Mono', Menlo, Consolas, monospace"


class Markup(str):
    """Text that is already markup, so it is not escaped again."""

    __slots__ = ()


STYLE = Markup(
    ".slewline{font:13px/1.4 system-ui,'DejaVu Sans',sans-serif;display:flex;flex-wrap:wrap;gap:10px 28px;"
    "align-items:flex-start;color:inherit;background:none;margin:4px 0}"
    ".slewline>*{max-width:100%}"
    ".slewline>.says{flex:0 0 100%}"
    ".slewline svg{max-width:100%;height:auto}"
    f".slewline.slewline :is(td,th,svg,pre){{font-family:{MONO}}}"
    ".slewline.slewline table{border-collapse:collapse;margin:0;border:0;font-size:12px;table-layout:auto;width:auto;"
    "color:inherit}"  # in pages that are not standard HTML, tables do not inherit it
    ".slewline.slewline table tr:nth-child(n){background:none;border:0}"
    ".slewline.slewline table tr:nth-child(n):is(.now,:hover){background:#8883}"
    ".slewline.slewline table :is(td,th){padding:1px 12px 1px 0;border:0;border-bottom:1px solid #8884;text-align:left;"
    "white-space:nowrap;vertical-align:top;color:inherit;max-width:none;background:none;unicode-bidi:isolate}"
    ".slewline.slewline table .right{text-align:right}"
    ".slewline.slewline table th{font-weight:600}"
    ".slewline .quiet{opacity:.72}"
    ".slewline .scrolls{overflow:auto;max-height:420px;margin-bottom:10px}"
    ".slewline pre{margin:0;background:none;color:inherit}"
)


def element(tag: str, /, *children: str | Iterable[str], **attributes: object) -> Markup:
    """Return an HTML or SVG element.

    Args:
        children: strings, which are escaped, and `Markup`, which is not; or iterables of these.
        attributes: `class_` stands for "class", `stroke_width` for "stroke-width"; an attribute that is None
            is left out.
    """
    given = "".join(
        f' {name.rstrip("_").replace("_", "-")}="{_escaped(str(value))}"'
        for name, value in attributes.items()
        if value is not None
    )
    inner = "".join(
        child if isinstance(child, Markup) else _escaped(child)
        for each in children
        for child in ([each] if isinstance(each, str) else each)
    )
    return Markup(f"<{tag}{given}>{inner}</{tag}>")


def _escaped(text: str) -> str:
    """Return text with markup escaped, and with "?" for each character that UTF-8 files cannot contain."""
    return escape(text.encode("utf-8", "replace").decode("utf-8"))


def card(caption: str, *pieces: str) -> Markup:
    """Return a card for a notebook: a line of text, and below it the pieces, side by side as space permits."""
    return element("div", element("style", STYLE), element("b", caption, class_="says"), pieces, class_="slewline")


def table(
    head: Sequence[str], rows: Iterable[Sequence[str]], right: Sequence[int] = (), now: int | None = None
) -> Markup:
    """Return a table.

    Args:
        head: the column names; empty for no header.
        right: the indices of the columns to align right, as for numbers.
        now: the index of the row to highlight; None for none.
    """

    def line(tag: str, cells: Sequence[str], class_: str | None = None) -> Markup:
        sides = ("right" if n in right else None for n in range(len(cells)))
        return element(
            "tr", [element(tag, cell, class_=side) for cell, side in zip(cells, sides, strict=True)], class_=class_
        )

    body = [line("td", cells, "now" if n == now else None) for n, cells in enumerate(rows)]
    return element("table", element("thead", line("th", head)) if head else "", element("tbody", body))
