"""Notebook views of chips, steps and shafts: HTML and SVG without scripts, in the colours of the page.

The classes of these objects have `_repr_html_` or `_repr_svg_` methods, which pass plain values to the
functions here. All markup is produced by `element` (`markup.py`), which escapes text.
"""
