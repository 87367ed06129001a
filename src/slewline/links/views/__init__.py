"""Views of a server: its state, dialogues, signals, findings on a terminal.

The data of a web page or a terminal is made here, without the name of any part; a part contributes its `shows()`.
"""
