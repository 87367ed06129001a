"""The language of the chips: decoders, assembler, disassembler, linter, reference.  It only reads data sheets.

A dialect is the form in which commands are written, sent and stored: a folder with a class that has the interface of
`dialect.py`.  A rule of the linter is in `lint.py` if it holds for any program, in the `rules.py` of a dialect, in
`host_rules.py` if it is about the pins that a host drives, and in `checks.py` of a chip if it needs knowledge of the
chip.  The common base of the ramp calculators of all parts is `ramp_answers.py`.
"""
