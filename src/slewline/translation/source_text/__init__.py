"""The source of a translation: its text becomes actions, with the register values known at each command.

reading            a program: the actions of every line, and assumptions about facts missing in the text
role_reader        the actions of a command, by its role
source_registers   the register values at every command, as far as the text shows them
program_labels     the names of the instructions to which a program or its host jumps
bits               outputs and inputs that a command selects by a number
"""
