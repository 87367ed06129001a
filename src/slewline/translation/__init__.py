"""Translation: a program of one part becomes a program of another one, and both are run to compare them.

    meaning.py   what a program does, in the field's terms: the form between two dialects
    reading      a text in a dialect -> that form, by the roles of its rows (core/datasheet/roles.py)
    writers      that form -> a text: a module for our own parts, and one for each other target
    report.py    what became of each line: the same, nearly, not possible, assumed
    proof        source and result are run, and compared within what the report states

A new target is a class with the face of `target_writer.py`, in a module of `writers`, and a row of `TARGETS` there.
"""
