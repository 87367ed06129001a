"""Data sheets as data: pins, commands, registers, times, options, channels, quirks; and the lookup of parts by name.

A fact that several modules need has its own column in a row, so that no text has to be parsed.  Roles
(`roles.py`) name the purpose of a pin or a command across parts: wiring, hosts and rules use them.  The
`reflex` of a pin is its direct effect on a running motor; `at_once` of a command is its effect before
the end of a motion.  An option is a row (`option.py`), and its value is checked before use.  A host
reaches a part over a channel (`channel.py`).
"""
