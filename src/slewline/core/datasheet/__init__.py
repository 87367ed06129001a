"""Data sheets as data: pins, commands, registers, times, options, channels, quirks; how parts are found by name.

A fact with two readers is a column of its row, so that no text needs to be parsed.  Roles (`roles.py`) are the words
for the purpose of a pin or a command that several parts have: wiring, hosts and rules go by them.  The `reflex` of a
pin is what it does to a running motor by itself, `at_once` in a row that the command does not wait for the end of a
motion.  An option is a row (`option.py`), checked before use.  How a host reaches a part is a channel (`channel.py`).
"""
