"""Runs the code blocks of a page, in their order, in the current directory.

    python    is executed; blocks of a page share their names, and what one prints is kept.  If the first line is a
              comment with a file name (`# test_it.py`), it is written to that file instead, or added to it
              (`# test_it.py, continued`); modules in such files can be imported
    toml      is written to the file that its first line names (`# drill.toml`)
    text      is written likewise (`; go.cy525`); without a name it is what the Python block before it printed
    console   `$ slewline ...` is called, and must print what follows; a line `...` stands for any lines.  sigrok-cli
              is called likewise; where it is missing, the rest of the page is skipped
    powershell   the same behind `PS> `, with the paths of Windows

A picture is compared with the file of its name that a block before it has written, see `pictures`.

A block in another language fails: nothing on a page that is tested stays untried.
"""

from __future__ import annotations

import os
import re
import runpy
import shlex
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from functools import partial
from io import BytesIO, StringIO, TextIOWrapper
from pathlib import Path

from sybil import Example, Sybil
from sybil.evaluators.python import PythonEvaluator
from sybil.parsers.markdown import CodeBlockParser
from sybil.parsers.markdown.lexers import FencedCodeBlockLexer

from slewline.cli.main import invoke

from ..oracles import programs
from .pictures import images

ROOT = Path(__file__).parents[2]
NAMED = re.compile(r"(?:#|;) ([\w/]+\.[\w-]+)\b(, continued)?.*\n")
execute = PythonEvaluator()


def python(example: Example) -> str | None:
    """Execute, or write to a file."""
    if written(example):
        return None
    with redirect_stdout(StringIO()) as out:
        failure = execute(example)
    example.namespace["__printed__"] = out.getvalue()
    return failure


def text(example: Example) -> str | None:
    """Write to a file, or compare with what was printed."""
    if written(example):
        return None
    return differs(example.parsed, example.namespace.pop("__printed__", "(no Python block before)"))


def toml(example: Example) -> str | None:
    """Write to a file."""
    return None if written(example) else "the first line names no file"


def written(example: Example) -> bool:
    """Write the block to the file that its first line names, if it does."""
    named = NAMED.match(example.parsed)
    if named:
        before = Path(named[1]).read_text("utf-8") + "\n\n" if named[2] else ""
        Path(named[1]).write_text(before + example.parsed, "utf-8")
    return bool(named)


def console(example: Example, prompt: str = "$ ", slash: str = "/") -> str | None:
    """Call every command, and compare what it prints."""
    calls = re.split(rf"^{re.escape(prompt)}", example.parsed, flags=re.MULTILINE)
    if calls[0]:
        return f"such a block begins with {prompt}"
    for call in calls[1:]:
        command, _, shown = call.partition("\n")
        failure = differs(shown, called(shlex.split(command.replace(slash, "/"), comments=True)))
        if failure:
            return f"{prompt}{command}\n{failure}"
    return None


powershell = partial(console, prompt="PS> ", slash="\\")


def called(words: list[str]) -> str:
    """What a command prints."""
    if words[0] == "make":  # without what sets up an environment; what it prints is not shown
        assert re.search(rf"^{words[1]}: ## ", (ROOT / "Makefile").read_text("utf-8"), re.MULTILINE), words
        for call in runpy.run_path(str(ROOT / "tools/setup.py"))["CALLS"][words[1]](str(ROOT)):
            if call[:2] == ["-m", "slewline"]:
                called(call[1:])
        return ""
    if words[:2] == ["py", "tools/setup.py"]:  # make, where there is none
        return called(["make", *words[2:]])
    if words[0] in (".", ".venv/Scripts/activate", "mkdir", "cd") or words[:2] == ["pip", "install"]:
        return ""  # done in earnest by tests/docs/test_newcomer.py
    if words[0] == "pytest":
        # Without the plugins that only happen to be installed here: loading them takes longer than the tests.
        alone = os.environ | {"PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"}
        plugins = ("-p", "no:cacheprovider", "-p", "slewline.testing.plugin")
        command = [sys.executable, "-m", "pytest", *plugins, *words[1:]]
        ran = subprocess.run(command, check=False, capture_output=True, text=True, env=alone)
        return re.sub(r" in [\d.]+s", "", ran.stdout)
    if words[0] == "sigrok-cli":
        return programs.called(words)
    assert words[0] == "slewline", words
    out = TextIOWrapper(BytesIO(), "utf-8", write_through=True)
    with redirect_stdout(out), redirect_stderr(out):
        invoke(words[1:])
    return out.buffer.getvalue().decode("utf-8")


def differs(shown: str, printed: str) -> str | None:
    """What is wrong, if the page does not show what was printed."""
    pattern = "".join(
        r"(?:.*\n)*?" if line == "..." else re.escape(line.rstrip()) + r" *\n" for line in shown.splitlines()
    )
    if re.fullmatch(pattern, printed):
        return None
    return f"the page shows\n\n{shown}\nbut this was printed\n\n{printed}"


EVALUATORS = {"python": python, "text": text, "toml": toml, "console": console, "powershell": powershell}
SYBIL = Sybil([images, *(CodeBlockParser(language, evaluate) for language, evaluate in EVALUATORS.items())])


def run_page(path: Path, languages: tuple[str, ...] = tuple(EVALUATORS)) -> int:
    """Run the blocks of a page in some languages, and compare its pictures; returns how many blocks there were."""
    document = SYBIL.parse(path)
    count = 0
    with modules_here():
        for example in document.examples():
            if wanted(example, languages):
                example.evaluate()
            count += language_of(example) in languages
    return count


@contextmanager
def modules_here() -> Iterator[None]:
    """Modules in the current directory can be imported, as those beside a script can, and are forgotten afterwards."""
    here, before, known = os.getcwd(), [*sys.path], set(sys.modules)
    sys.path.insert(0, here)
    try:
        yield
    finally:
        sys.path[:] = before
        for name in sys.modules.keys() - known:
            file = Path(getattr(sys.modules[name], "__file__", None) or os.sep)
            if file.is_relative_to(here) and not file.is_relative_to(ROOT):  # ours, and .venv, stay whatever is here
                del sys.modules[name]


def wanted(example: Example, languages: tuple[str, ...]) -> bool:
    """Whether to look at a picture, a block in one of the languages, or what such a one has printed."""
    language = language_of(example)
    return language in (None, *languages) or (language == "text" and bool(example.namespace.get("__printed__")))


def language_of(example: Example) -> str | None:
    """The language of a block; None: a picture."""
    return example.region.lexemes.get("arguments")


def languages_of(path: Path) -> set[str]:
    """The languages of all blocks of a page, without the `{toctree}` and the like of the page itself."""
    document = SYBIL.parse(path)
    return {region.lexemes["language"] for region in FencedCodeBlockLexer(r"\w[^\n]*")(document)}
