"""Reading back: what the writers wrote is read by parsers that share no code with them, and run on paper.

    surroundings.py     the inputs of such a run, and what it did: a trace
    linuxcnc_reader.py  O-words, parameters and expressions      rs274.py   the same text in LinuxCNC's own interpreter
    grbl_reader.py      G-code as grbl 1.1 takes it              klipper_reader.py macros and their commands
    tmcl_reader.py      assembler and processor for TMCL         sketch.py  the C++ of a sketch
    script_reader.py    a host script, by Python's own parser

Each of them takes what its target takes, as far as writers use it, and refuses everything else: a line that the target
would refuse has to be refused here.
"""
