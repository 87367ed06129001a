"""Motion: plans, step trains, axes with their past, quantities measured on an axis, and motor outputs.

The `quantities()` of an axis or a part are its values over time, to be plotted or written to a file;
`quantity.py` and `history.py` implement them.
"""
