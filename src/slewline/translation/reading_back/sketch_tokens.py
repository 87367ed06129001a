"""The words of a sketch, and a position among them."""

from __future__ import annotations

import re
from typing import NamedTuple

from .surroundings import RefusedLine

TOKEN = re.compile(
    r'\s*(#[^\n]*|"[^"]*"|\d+\.\d+|\d+L?|[A-Za-z_]\w*|->|::|\+\+|==|!=|<=|>=|&&|\|\||[-+*/%<>=!?:;,.(){}\[\]&])'
)


class Token(NamedTuple):
    """A word, and its line."""

    text: str
    line: int


class SketchTokens:
    """The words of a sketch, in order, and a position among them.

    Raises:
        RefusedLine: a character sequence is not a word of a sketch.
    """

    def __init__(self, text: str) -> None:
        self.tokens: list[Token] = []
        for line, code in enumerate(text.splitlines(), 1):
            code = code.partition("//")[0]
            place = 0
            while code[place:].strip():
                found = TOKEN.match(code, place)
                if not found:
                    raise RefusedLine(line, code, "not C++ that writers use")
                self.tokens.append(Token(found[1], line))
                place = found.end()
        self.at = 0

    @property
    def here(self) -> str:
        """The next token; empty at the end."""
        return self.tokens[self.at].text if self.at < len(self.tokens) else ""

    def take(self, text: str = "") -> str:
        """Return the next token, and advance."""
        found = self.here
        if text and found != text:
            raise self.refused(f"{text} is missing")
        self.at += 1
        return found

    def refused(self, reason: str) -> RefusedLine:
        """Return the error for the line at the current position."""
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
        """Skip ( ... )."""
        depth = 0
        while True:
            depth += {"(": 1, ")": -1}.get(self.take(), 0)
            if not depth:
                return
