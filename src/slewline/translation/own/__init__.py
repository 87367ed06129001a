"""The writer for our own parts: the effect of a program -> text in another part's dialect, by the roles of rows.

line_stream.py    the actions in the target's order; actions that need a stored program are put into one
nearest_rates.py  rates and ramps: groups of settings, the target's nearest values, and how far these are off
actions.py        an action -> instructions, with a method for each kind; conditions.py contains waits and branches
layout.py         labels and addresses; the size is checked against the program memory
limits.py         limits of the target, in words, with the places in the manual that state them
part_writer.py    the writer, composed of all of these
"""
