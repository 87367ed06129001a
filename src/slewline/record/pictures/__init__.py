"""Pictures: figures of motions, lanes of pins, timing diagrams.

A kind of picture is a value with a title and a description, and a function draw(it, width, dark) in a
file of its own; `timing_diagram.py` is the example to follow.  `save` (`picture_files.py`) writes the
file completely or not at all.
"""
