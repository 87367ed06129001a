"""Views of a server: its state, dialogues, signals, and findings on a terminal.

The data for a web page or a terminal is made here.  The code names no part; each part contributes its
own data by `shows()`.
"""
