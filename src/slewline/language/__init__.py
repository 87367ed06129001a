"""The chips' languages: decoders, assembler, disassembler, linter and reference.  They read only the data sheets.

A dialect is the form in which commands are written, sent and stored: a folder with a class that implements
`dialect.py`.  A lint rule is in `lint.py` if it holds for any program, in a dialect's `rules.py` if it holds for that
dialect, in `host_rules.py` if it is about the pins that a host drives, and in a chip's `checks.py` if it requires
knowledge of the chip.  The common base of the ramp calculators of all parts is `ramp_answers.py`.
"""
