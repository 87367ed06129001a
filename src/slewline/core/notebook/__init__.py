"""What a notebook shows of chips, steps and shafts: HTML and SVG in which nothing runs, in the colours of the page.

The classes that are shown have `_repr_html_` or `_repr_svg_`, which call functions of plain values here.  All markup
is made by `element` (`markup.py`), which escapes texts.
"""
