"""The writer for our own parts: the effect of a program -> a text in the dialect of another part, by roles of rows.

line_stream.py    the actions in the order of the target: actions for a stored program go into one
nearest_rates.py  rates and ramps: groups of settings, the nearest values, the differences
actions.py        an action -> instructions, a method for each; conditions.py has waits and branches
layout.py         labels and addresses; the size is checked against the program memory
limits.py         limits of the target, in words, with their place in the manual
part_writer.py    all of them together
"""
