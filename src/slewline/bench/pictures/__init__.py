"""What a bench records, draws and writes, and its timing diagrams.

What is recorded is decided in `signals.py`.  A call that draws checks the suffix of its file first; `timing.py` is
the model.
"""
