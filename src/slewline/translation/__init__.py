"""Translation: a program of one part becomes a program of another one, and both are run to compare them.

    meaning.py   what a program does, in the field's terms: the form between two dialects
    reading      a text in a dialect -> that form, by the roles of its rows (core/datasheet/roles.py)
    own          that form -> a text for one of our parts
    writers      that form -> a text for another target: `language_writer.py` has what all languages share
    reading_back a text for another target -> what it does, read by parsers that share no code with the writers
    report.py    what became of each line: the same, nearly, not possible, assumed
    proof        source and result are run, and compared within what the report states

A new target is a `LanguageWriter` in a module of `writers`, a reader, and a row of `TARGETS` in `writers/__init__.py`.
"""
