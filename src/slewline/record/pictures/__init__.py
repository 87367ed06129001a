"""Pictures: figures of motions, lanes of pins, timing diagrams.

Each kind of picture has a class with a title and a description, and a function draw(picture, width,
dark) in a file of its own; `timing_diagram.py` is the example to follow.  `save` (`picture_files.py`)
writes a picture to a file, completely or not at all.
"""
