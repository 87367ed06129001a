r"""Foreign protocols: a browser can be made to send bytes to a port of this machine; none of them may reach a module.

A web page of any site may make its reader's browser connect to 127.0.0.1.  Such a connection begins in one of a few
ways, none of which a host of a module uses, so the first bytes of a connection are checked:

    HTTP, WebSocket    METHOD TARGET for the known methods; METHOD TARGET HTTP/ for any other
    HTTP/2             PRI * HTTP/2.0: a method as well
    TLS                16 03 00..04, two bytes, 01: a record with a ClientHello
    SSL 2              80, a byte, 01, the version: an old hello, which WebRTC still sends
    control port       {"do": a client that mistakes this port for a control port
    STUN, TURN         00 01 or 00 03, two bytes, 21 12 A4 42; after two bytes of length in ICE over TCP

Bytes that may still become one of these are held back until a later byte decides.  A carriage return
decides, because no request line contains one; the first line from a host is therefore passed on when it is
complete, and has no effect on a module before that.  In binary data, the first byte that no method can
contain, such as a count, decides.  On a register port, a request may begin with
24, which is $ in ASCII, and a method may contain a $.  Therefore, on such a port, only text that begins with a
letter can be a method; only two of the register requests begin with one, 44 (D) and 54 (T).

A pause of `HOLD_S` decides, too: a single byte with a meaning, such as Q, is passed on a little later.
Bytes after the pause are checked as before, so a client that pauses that long is still disconnected
when it is recognised, but its first bytes have been passed on by then.  Line ends alone are passed on
immediately, because they set the rate of a chip that adapts to its host; a foreign request after them
is still recognised.

This check cannot detect a program on this machine that sends the same bytes as a host, nor the bytes
that a browser may be made to send after a different beginning.
"""

from __future__ import annotations

import re

METHODS = ("GET", "HEAD", "POST", "PUT", "DELETE", "CONNECT", "OPTIONS", "PATCH", "TRACE", "PRI")
HOLD_S = 1.0  # no program pauses so long within its first bytes
LONGEST = 1024  # bytes after which no beginning is possible

TOKEN = r"[!#$%&'*+.^_`|~0-9A-Za-z-]"  # character of a method
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
    """The first bytes by which foreign protocols are recognised on one kind of port.

    Args:
        method: a regular expression for an HTTP method on such a port.
        own: the name of the protocol that the port itself serves, which is not foreign here; "" for none.
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
        """Return the name of the foreign protocol that these bytes begin; empty if none is recognised (yet)."""
        return next((name for name, whole in self.whole.items() if whole.match(seen)), "")

    def undecided(self, seen: bytes) -> bool:
        """Return whether the bytes may still become the beginning of a foreign protocol."""
        return len(seen) <= LONGEST and self.part.match(seen) is not None


def classes(form: str) -> list[str]:
    r"""Return the bytes of a hello, each as a character class of a regular expression: "00-04" becomes [\x00-\x04]."""
    sets = [re.sub("[0-9a-f]{2}", r"\\x\g<0>", byte).replace(",", "") for byte in form.split()]
    return [f"[{one}]" if one != "--" else "." for one in sets]


def nested(bytes_: list[str]) -> str:
    """Return a regular expression for any beginning of a sequence of bytes: a(?:b(?:c)?)? for abc."""
    return "(?:".join(bytes_) + ")?" * (len(bytes_) - 1)


TEXT = Greetings()
REGISTERS = Greetings(LETTER)
CONTROL = Greetings(own="control")


class Preamble:
    """The first bytes of a connection; `protocol` is the name of a foreign protocol once recognised, else ""."""

    def __init__(self, greetings: Greetings = TEXT) -> None:
        self.greetings = greetings
        self.seen, self.pending = b"", b""
        self.holding = self.undecided = True
        self.protocol = ""

    def take(self, data: bytes) -> bytes:
        """Return the bytes that may be passed on now that `data` has arrived; none if the protocol is foreign."""
        if not self.undecided:
            return b"" if self.protocol else data
        self.seen += data
        self.pending += data
        self.protocol = self.greetings.known(self.seen)
        self.undecided = not self.protocol and self.greetings.undecided(self.seen)
        if self.protocol:
            self.pending = b""
        elif not self.undecided or not self.holding or not self.seen.strip(b"\r\n"):
            return self._let_go()
        return b""

    def release(self) -> bytes:
        """Return the bytes held back, and stop holding back; a foreign protocol recognised later is still reported."""
        self.holding = False
        return self._let_go()

    def _let_go(self) -> bytes:
        pending, self.pending = self.pending, b""
        return pending
