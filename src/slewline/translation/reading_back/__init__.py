"""Reading back: parsers that follow the text of a translated program, and share no code with the writers.

"On paper" means that the statements are followed here, without the target.  Only rs274 runs a result in
a target's own interpreter.

    surroundings.py     the inputs of a program on paper, and the trace of its events
    linuxcnc_reader.py  O-words, parameters and expressions
    rs274.py            the same text in LinuxCNC's own interpreter
    grbl_reader.py      G-code as accepted by grbl 1.1
    klipper_reader.py   macros and their commands
    tmcl_reader.py      assembler and processor for TMCL
    sketch.py           the C++ of a sketch
    script_reader.py    a host script, by Python's own parser

Each parser accepts its target's language, as far as the writers use it, and refuses everything else: a
line that the target would refuse must be refused here.
"""
