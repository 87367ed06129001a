r"""Strangers: a browser can be made to send bytes to a port of this machine, and no such byte may reach a module.

A page of any site may let the browser of its reader connect to 127.0.0.1.  What goes out begins in one of a few ways,
and no host of a module begins so; the first bytes of a connection are looked at:

    HTTP, WebSocket    METHOD TARGET for the methods that are known; METHOD TARGET HTTP/ for any other
    HTTP/2             PRI * HTTP/2.0: a method as well
    TLS                16 03 00..04, two bytes, 01: a record with a ClientHello
    SSL 2              80, a byte, 01, the version: a hello of old, which WebRTC still sends
    control port       {"do": a client that took this port for it
    STUN, TURN         00 01 or 00 03, two bytes, 21 12 A4 42; after two bytes of length in ICE over TCP

What may still become one of these is held back until a byte decides.  A carriage return does, for no request line has
one inside: so the first line of a host is passed on when it is complete, and until then it means nothing to a module.
In binary a count decides, which is no character of a method.  Of registers, `24 nn` would be the beginning of a method:
there, a method begins with a letter, which no request of a register does but 44.

A pause of `HOLD_S` decides, too: a lone byte that does mean something, such as Q, is served all the same, a little
later.  What comes after the pause is examined as before, so a stranger that pauses so long is hung up on when it is
known, and has passed on what was held.  Line ends alone are passed on at once, for they set the rate of a
chip that adapts to its host; a request after them is known.

What cannot be seen here: a program of this machine that sends what a host would send, and whatever a browser may be
made to send after a beginning that is none of these.
"""

from __future__ import annotations

import re

METHODS = ("GET", "HEAD", "POST", "PUT", "DELETE", "CONNECT", "OPTIONS", "PATCH", "TRACE", "PRI")
HOLD_S = 1.0  # no program pauses so long inside its first words
LONGEST = 1024  # bytes after which nothing is a beginning any more

TOKEN = r"[!#$%&'*+.^_`|~0-9A-Za-z-]"  # a character of a method
LETTER = rf"(?!D[^Ee])[A-Za-z]{TOKEN}*"  # a method on registers
REQUEST = rf"(?:(?:{'|'.join(METHODS)}) [!-~]|METHOD [!-~]+ HTTP/)"
UNDECIDED = r"(?:METHOD(?: [!-~]*| [!-~]+ H?| [!-~]+ HTT?| [!-~]+ HTTP)?)?"
HELLOS = {  # in hexadecimal; --: any byte
    "TLS": ("16 03 00-04 -- -- 01",),
    "SSL": ("80 -- 01 00-03 00-03",),
    "control": ("7b 22 64 6f 22",),
    "STUN": ("00 01,03 -- -- 21 12 a4 42", "00 14-ff 00 01 -- -- 21 12 a4 42", "01 -- 00 01 -- -- 21 12 a4 42"),
}


class Greetings:
    """How strangers begin on a port of a kind.

    Args:
        method: a method of HTTP there, as a regular expression.
        own: the hello that clients send there.
    """

    def __init__(self, method: str = f"{TOKEN}+", own: str = "") -> None:
        self.whole = {"HTTP": re.compile(rf"[\r\n]*{REQUEST.replace('METHOD', method)}".encode())}
        parts = [rf"[\r\n]*{UNDECIDED.replace('METHOD', method)}"]
        for name, forms in HELLOS.items():
            if name == own:
                continue
            self.whole[name] = re.compile("|".join("".join(classes(form)) for form in forms).encode(), re.DOTALL)
            parts += [nested(classes(form)) for form in forms]
        self.part = re.compile(rf"(?:{'|'.join(parts)})\Z".encode(), re.DOTALL)

    def known(self, seen: bytes) -> str:
        """Return the protocol that begins so; empty: none of these, or not yet."""
        return next((name for name, whole in self.whole.items() if whole.match(seen)), "")

    def undecided(self, seen: bytes) -> bool:
        """Return whether it may still become one of these."""
        return len(seen) <= LONGEST and self.part.match(seen) is not None


def classes(form: str) -> list[str]:
    r"""Return the bytes of a hello, each as a class of a regular expression: "00-04" as [\x00-\x04]."""
    sets = [re.sub("[0-9a-f]{2}", r"\\x\g<0>", byte).replace(",", "") for byte in form.split()]
    return [f"[{one}]" if one != "--" else "." for one in sets]


def nested(bytes_: list[str]) -> str:
    """Return what matches any beginning of a sequence: a(?:b(?:c)?)?."""
    return "(?:".join(bytes_) + ")?" * (len(bytes_) - 1)


TEXT = Greetings()
REGISTERS = Greetings(LETTER)
CONTROL = Greetings(own="control")


class Preamble:
    """The first bytes of a connection, until it is clear what they are; `stranger` is what a stranger speaks."""

    def __init__(self, greetings: Greetings = TEXT) -> None:
        self.greetings = greetings
        self.seen, self.held = b"", b""
        self.holding = self.undecided = True
        self.stranger = ""

    def take(self, data: bytes) -> bytes:
        """Return what may be passed on now that these bytes have come; nothing, once a stranger is known."""
        if not self.undecided:
            return b"" if self.stranger else data
        self.seen += data
        self.held += data
        self.stranger = self.greetings.known(self.seen)
        self.undecided = not self.stranger and self.greetings.undecided(self.seen)
        if self.stranger:
            self.held = b""
        elif not self.undecided or not self.holding or not self.seen.strip(b"\r\n"):
            return self._let_go()
        return b""

    def release(self) -> bytes:
        """Return what is held back, and hold back no more; a stranger that is known later is still reported."""
        self.holding = False
        return self._let_go()

    def _let_go(self) -> bytes:
        held, self.held = self.held, b""
        return held
