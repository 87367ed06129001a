"""What pyvcd reads in a VCD file."""

from __future__ import annotations

from vcd.reader import TokenKind, tokenize


def read(path):
    """The type and size of every variable, and its changes: (time, value)."""
    names, scopes, variables, changes, now = {}, [], {}, {}, 0
    with open(path, "rb") as file:
        for token in tokenize(file):
            if token.kind is TokenKind.SCOPE:
                scopes.append(token.scope.ident)
            elif token.kind is TokenKind.UPSCOPE:
                scopes.pop()
            elif token.kind is TokenKind.VAR:
                name = names[token.var.id_code] = ".".join([*scopes, token.var.reference])
                variables[name], changes[name] = (token.var.type_, token.var.size), []
            elif token.kind is TokenKind.CHANGE_TIME:
                now = token.time_change
            elif token.kind.name.startswith("CHANGE_"):
                changes[names[token.data.id_code]].append((now, token.data.value))
    return variables, changes
