"""The writer for our own parts: what a program does -> a text in the dialect of another part, by the roles of its rows.

line_stream.py    the actions in the order of the target: what belongs in a stored program goes into one
nearest_rates.py  rates and ramps: groups of settings, the values that come nearest, what differs
actions.py        an action -> instructions, a method for each; conditions.py has waits and branches
layout.py         labels and addresses; the size is checked against the program memory
limits.py         what the target has not, in words, with its place in the manual
part_writer.py    all of them together
"""
