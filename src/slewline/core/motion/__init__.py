"""Motion: plans, step trains, the axis with its past, what is measured of it, and what outputs show of it.

What an axis or a part does over time, to be drawn or written, are its `quantities()`, made of `quantity.py` and
`history.py`.
"""
