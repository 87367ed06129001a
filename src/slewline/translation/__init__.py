"""Translation of a program for one part to a program for another part; both programs are run and compared.

    meaning.py   the effect of a program, in motion-control terms: the form between two dialects
    reading      a text in a dialect -> that form, by the roles of its rows (core/datasheet/roles.py)
    own          that form -> a text for one of our parts
    writers      that form -> a text for another target: `language_writer.py` is the base of all languages
    reading_back a text for another target -> its effect, read by parsers that share no code with the writers
    report.py    the verdict on each line: the same, nearly, not possible; and the assumptions
    proof        source and result are run, and compared within the limits that the report states

A new target needs a `LanguageWriter` in a module of `writers`, a reader, and a row of `TARGETS` in
`writers/__init__.py`.
"""
