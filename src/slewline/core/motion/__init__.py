"""Motion: plans, step trains, the axis with its past, what is measured of it, and what outputs show of it."""
