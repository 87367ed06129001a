"""The words and symbols of a sketch, and a reading position among them."""

from __future__ import annotations

import re
from typing import NamedTuple

from .surroundings import RefusedLine

TOKEN = re.compile(
    r'\s*(#[^\n]*|"[^"]*"|\d+\.\d+|\d+L?|[A-Za-z_]\w*|->|::|\+\+|==|!=|<=|>=|&&|\|\||[-+*/%<>=!?:;,.(){}\[\]&])'
)


class Token(NamedTuple):
    """A word or symbol of a sketch, and the number of its line."""

    text: str
    line: int


class SketchTokens:
    """The tokens of a sketch, in order, and a reading position among them.

    Raises:
        RefusedLine: a line contains characters that are not a token of a sketch.
    """

    def __init__(self, text: str) -> None:
        self.tokens: list[Token] = []
        for line, code in enumerate(text.splitlines(), 1):
            code = code.partition("//")[0]
            place = 0
            while code[place:].strip():
                found = TOKEN.match(code, place)
                if not found:
                    raise RefusedLine(line, code, "not C++ that translations use")
                self.tokens.append(Token(found[1], line))
                place = found.end()
        self.at = 0

    @property
    def here(self) -> str:
        """The text of the next token; empty at the end of the sketch."""
        return self.tokens[self.at].text if self.at < len(self.tokens) else ""

    def take(self, text: str = "") -> str:
        """Return the text of the next token, and advance past it; if `text` is given, the token must be `text`."""
        found = self.here
        if text and found != text:
            raise self.refused(f"{text} is missing")
        self.at += 1
        return found

    def refused(self, reason: str) -> RefusedLine:
        """Return an error with the given reason, for the line at the reading position."""
        token = self.tokens[min(self.at, len(self.tokens) - 1)]
        return RefusedLine(token.line, token.text, reason)

    def skip(self) -> None:
        """Skip the next statement or block."""
        if self.here == "{":
            depth = 0
            while True:
                depth += {"{": 1, "}": -1}.get(self.take(), 0)
                if not depth:
                    return
        if self.here in ("if", "while", "for"):
            self.take()
            self.skip_brackets()
            self.skip()
            if self.here == "else":
                self.take()
                self.skip()
            return
        if self.here == "do":
            self.take()
            self.skip()
        while self.take() != ";":
            pass

    def skip_brackets(self) -> None:
        """Skip an opening bracket and everything up to and including the closing bracket that matches it."""
        depth = 0
        while True:
            depth += {"(": 1, ")": -1}.get(self.take(), 0)
            if not depth:
                return
