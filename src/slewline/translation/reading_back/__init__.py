"""Reading back: the results of the writers are read by parsers that share no code with them, and run on paper.

    surroundings.py     the inputs of such a run, and its events: a trace
    linuxcnc_reader.py  O-words, parameters and expressions      rs274.py   the same text in LinuxCNC's own interpreter
    grbl_reader.py      G-code as accepted by grbl 1.1           klipper_reader.py macros and their commands
    tmcl_reader.py      assembler and processor for TMCL         sketch.py  the C++ of a sketch
    script_reader.py    a host script, by Python's own parser

Each of them accepts the language of its target, as far as writers use it, and refuses everything else: a line that the
target would refuse has to be refused here.
"""
