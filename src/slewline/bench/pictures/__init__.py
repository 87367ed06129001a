"""Recording, pictures and files of a bench, and its timing diagrams.

`signals.py` selects the signals that are recorded.  A call that draws checks the extension of its file first;
`timing.py` is the model.
"""
