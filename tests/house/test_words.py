"""Messages, docstrings, comments and pages keep to the words of the field (docs/explanation/glossary.md).

What still has others is counted in words.toml; nothing may be added to it, and what is mended is taken out.
"""

from __future__ import annotations

import ast
from pathlib import Path

from tests.house.words import ROOT, banned, comments, counted, files, grown, listed, prose, strings, texts


def test_phrases_that_readers_stumble_over_only_become_fewer() -> None:
    now, before = counted(), listed()
    more = grown(now, before)
    places = [
        f"{name}: {phrase!r}: write {instead}: ...{around}..."
        for name in sorted({name for name, _ in more})
        for text in texts(ROOT / name)
        for phrase, instead, around in banned(text)
        if (name, phrase) in more
    ]
    assert not more, "\n".join((*more.values(), *places))
    fewer = grown(before, now)
    assert not fewer, "\n".join((*fewer.values(), "mended; this writes the table: python -m tests.house.words"))


def test_every_room_is_read() -> None:
    names = {file.relative_to(ROOT).as_posix() for file in files()}
    assert {
        "README.md", "firmware/common/motion.c", "firmware/common/protocol.h", "firmware/uno/step.S", "tools/setup.py",
        "src/slewline/drive/talk.py", "src/slewline/panel/web_server.py", "src/slewline/errors.py", "benchmarks/run.py",
        "docs/howto/serve.md",
    } <= names  # fmt: skip
    assert {".js", ".ipynb"} <= {Path(name).suffix for name in names} and any(
        name.startswith("templates/") for name in names
    )
    assert not any(name.startswith("docs/decisions/") for name in names)


def test_every_phrase_is_found_and_no_other() -> None:
    wrong = (
        'f"{path}: that is over; it is {now}"\n"""A finding is\ntold anew by somebody."""\nx = "begin"  # at\n# once\n'
    )
    found = [phrase for text in strings(ast.parse(wrong)) for phrase, *_ in banned(text)]
    assert found == ["that is over; it is", "anew", "told", "somebody"]
    assert [phrase for text in comments(wrong) for phrase, *_ in banned(text)] == ["at once"]
    assert not banned(prose("It is over.\n\n```text\nanew\n```\nThe edges are told apart by `somebody`.\n"))


def test_what_has_grown_is_named() -> None:
    before = {"a.py": {"told": 2, "anew": 1}}
    now = {"a.py": {"told": 3}, "b.c": {"at once": 1}}
    assert [*grown(now, before).values()] == ["a.py: 'told' 2 -> 3", "b.c: 'at once' 0 -> 1"]
    assert [*grown(before, {"a.py": {"told": 2}})] == [("a.py", "anew")]
