"""Views of a server: its state, dialogues, signals, and findings on a terminal.

The data for a web page or a terminal is made here, without naming any part; a part contributes its `shows()`.
"""
