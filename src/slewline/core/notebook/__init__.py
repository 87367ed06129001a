"""Views of chips, steps and shafts in a notebook: HTML and SVG without scripts, in the colours of the page.

The classes shown have `_repr_html_` or `_repr_svg_`, which call functions of plain values here.  All markup is made by
`element` (`markup.py`), which escapes texts.
"""
