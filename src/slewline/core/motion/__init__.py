"""Motion: plans, step trains, the axis with its past, quantities measured on it, and the outputs that show it.

The `quantities()` of an axis or a part are its values over time, to be plotted or written to a file; `quantity.py`
and `history.py` implement them.
"""
