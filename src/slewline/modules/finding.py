"""Search for a module on a port: the rate at which it answers, and whether its lines have checksums.

The search sends a query that changes nothing.  If the module is set to a rate other than the query's,
it may receive wrong characters, but these form no command (tests/modules/test_finding.py).
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from contextlib import suppress
from types import MappingProxyType
from typing import TYPE_CHECKING

from ..core.datasheet.table import Sheet
from ..errors import UsageError
from .adapter import FramedSpeech
from .deviations import deviations
from .failures import DamagedAnswer, NoAnswer, RefusedCommand
from .module import REPORT_S, DialogueRecord, Module
from .module_port import ModulePort
from .speech import LineSpeech, QuerySpeech, speech_of
from .spoken import CR, Speech

if TYPE_CHECKING:
    from .raw import RawRecord

LOOK_S = 0.35  # silence at a rate, after which the next one is tried
FOLLOWS_S = 0.05  # silence after which an answer counts as complete
MOST_RECEIVED = 1024  # characters of an answer that are read
LOOKS = 2  # attempts at a rate: the first line may only end an earlier, incomplete one
START_S = 3.0  # a module may still be starting after its port was opened, which raises DTR


def find(
    where: str,
    sheet: Sheet,
    *,
    baud: int | None = None,
    checked: bool | None = None,
    address: int | None = None,
    transcript: DialogueRecord | None = None,
    may_move: bool = False,
    echo: bool = False,
    raw: RawRecord | None = None,
    report: Callable[[str], object] = lambda _text: None,
) -> Module:
    """Return the module at a port, after it has answered a query.

    Args:
        where: the port, a device or URL that pySerial accepts.
        sheet: the sheet of the part.
        baud: the rate; None: search for it if straps set it, otherwise use the usual rate of the part.
        checked: whether lines have checksums; None: detect this.
        address: the address of the module on a shared line; None: no address.
        transcript, may_move, report: as for `Module`.
        echo: whether the line echoes all sent characters.
        raw: records all characters on the line.

    Raises:
        UsageError: there is no such port; the part does not support a given setting; or `echo` is True, but
            the line does not echo.
        NoAnswer, DamagedAnswer: there is no answer, or the answer is not one of this part or contradicts
            `checked`.
        PortLost: the port is gone.
    """
    speech = speech_of(sheet, baud, checked, address)
    port = ModulePort(where, speech.setting, raw, echo)
    try:
        look = next(look for kind, look in LOOKS_FOR.items() if isinstance(speech, kind))
        module = look(Module(port, speech, transcript, may_move=may_move, report=report), baud, checked)
        _check_deviations(module)
        if echo and not port.echo.seen:
            raise UsageError(
                f"{where}: sent characters did not come back, so this line does not echo; leave out --echo"
            )
        return module
    except (NoAnswer, DamagedAnswer):
        port.close()
        port.check_echo()
        raise
    except BaseException:
        port.close()
        raise


# -------------------------------------------------------------------------------------------- parts that answer lines
def _by_lines(module: Module, baud: int | None, checked: bool | None) -> Module:
    """Query a module at one rate after another, or at `baud` only; return the module when it answers.

    If `checked` is None, the answers show whether lines have checksums.
    """
    first, begun_s = module.speech, module.port.clock()
    strange: list[str] = []
    rates = [*first.rates] if baud is None else [baud]
    for rate in rates:
        if module.port.clock() < begun_s + START_S:
            rates.append(rate)  # to be queried once more
        speech = _at(first, rate, bool(checked))
        if rate != first.baud or module.speech is not first:
            module.port.change(speech.setting)
        module.speech = speech
        for _ in range(LOOKS):
            received = _received(module)
            if checked is None and _has_checksums(speech, received):
                module.speech = _at(first, rate, True)
                received = _received(module)
            if checked and _lacks_checksums(speech, received) and received == _received(module):
                raise DamagedAnswer(
                    f"{module.name}: {speech.probe} with a checksum was answered with {received!r} at "
                    f"{speech.setting.in_full}, without a checksum: this module has no checksums; leave out --checksum"
                )
            if _is_answer(module.speech, received) or _of_old_firmware(module):
                module.transcript.note(f"the module answers at {module.speech.setting}")
                return module
            if received:
                strange.append(f"{received[:40]!r} at {rate} baud")
                _check_deviations(module)
            module.port.check_echo()
            if module.port.clock() > begun_s + REPORT_S:
                goes_on = "other rates are being tried" if baud is None else "the query is being repeated"
                module.report_once(f"received so far: {strange[-1] if strange else 'nothing'}; {goes_on}")
    raise NoAnswer(_unfound(module, baud, strange))


def _check_deviations(module: Module) -> None:
    """Query a module, and check that its answer, up to the silence after it, is as the sheet specifies.

    Raises:
        DamagedAnswer: two answers in a row deviate from the sheet in the same way.
    """
    speech = module.speech
    seen = ""
    for _ in range(LOOKS):
        module.tidy()
        module.send(speech.framed(speech.probe))
        silence = LOOK_S + 12 * speech.character_s
        received = b""
        for chunk in module.chunks(silence, speech.seconds(MOST_RECEIVED, silence), f"the answer to {speech.probe}"):
            received = chunk.data + module.listen(FOLLOWS_S + 12 * speech.character_s, MOST_RECEIVED)
            break
        found = deviations(speech, speech.probe, received)
        if found and found == seen:
            raise DamagedAnswer(
                f"{module.name}: {speech.probe} was answered with {received[:60]!r} at {speech.setting.in_full}, "
                f"which deviates from the data sheet: {found}"
            )
        if not found:
            return
        seen = found


def _at(speech: Speech, baud: int, checked: bool) -> Speech:
    return speech_of(speech.sheet, baud, checked, speech.address)


def _received(module: Module) -> bytes:
    """Query a module once; return its answer up to a carriage return, or all data received before silence."""
    module.tidy()
    module.send(module.speech.framed(module.speech.probe))
    received, probe = b"", module.speech.probe
    silence = LOOK_S + 12 * module.speech.character_s
    for chunk in module.chunks(
        silence, module.speech.seconds(module.speech.longest(probe), silence), f"the answer to {probe}"
    ):
        received += chunk.data
        if received.endswith(CR):
            break
    return received


def _has_checksums(speech: Speech, received: bytes) -> bool:
    """Return whether an answer to a line without a checksum reports a damaged line and itself ends with a checksum."""
    checked = _at(speech, speech.baud, True)
    with suppress(DamagedAnswer):
        return received.endswith(CR) and checked.is_garbled(checked.stripped(received[:-1]))
    return False


def _lacks_checksums(speech: Speech, received: bytes) -> bool:
    """Return whether an answer to a line with a checksum reports an invalid command and itself has no checksum."""
    plain = _at(speech, speech.baud, False)
    with suppress(DamagedAnswer):
        line = plain.stripped(received.removesuffix(CR))
        return received.endswith(CR) and bool(plain.refusal(line)) and not plain.is_garbled(line)
    return False


def _is_answer(speech: Speech, received: bytes) -> bool:
    """Return whether the data is an answer to the query `speech.probe`, or reports that the module is busy."""
    shape = next(shape for command, shape in speech.questions.values() if command == speech.probe)
    with suppress(DamagedAnswer):
        line = speech.stripped(received.removesuffix(CR))
        busy = bool(speech.refusal(line)) and not speech.is_garbled(line) and line == speech.busy
        return received.endswith(CR) and (busy or re.fullmatch(shape, line) is not None)
    return False


def _of_old_firmware(module: Module) -> bool:
    """Send a query with the checksum that old firmware uses; return whether the module answers.

    If it answers, these checksums are used from now on.  If lines have no checksums, no query is sent.
    """
    speech = module.speech
    if not isinstance(speech, LineSpeech) or not speech.checked:
        return False
    kept, speech.kept = speech.kept, 0
    if _is_answer(speech, _received(module)):
        return True
    speech.kept = kept
    return False


def _unfound(module: Module, baud: int | None, strange: list[str]) -> str:
    speech = module.speech
    rates = f"{baud} baud" if baud else f"{speech.rates[0]} to {speech.rates[-1]} baud"
    part = speech.sheet.part.upper()
    if strange:
        found = f"no {part} answers {speech.probe} at {rates}; received: {', '.join(dict.fromkeys(strange))}"
        known = "give --chip, and --baud and --checksum if you know them"
        return f"{module.port.where}: {found}; check the part and the line; {known}"
    others = "" if speech.address else "; a module that shares a line has an address: give --address"
    return (
        f"{module.port.where}: nothing answers {speech.probe} at {rates}, {speech.word}; check the "
        f"supply of the module, and its wires (RxD, TxD, ground){others}"
    )


# ------------------------------------------------------------------------------------------ parts that answer queries
def _by_queries(module: Module, baud: int | None, checked: bool | None) -> Module:
    """Let a module detect the rate, and query it; return the module when it answers.

    If it is silent, program entry may be open: entry is then ended, and the query repeated.
    """
    speech = module.speech
    (leave,) = speech.sheet.leave
    module.send(speech.wake)
    module.port.pause(4 * speech.character_s)
    try:
        _probed(module)
    except NoAnswer as silence:
        module.send(CR + leave.form.encode("ascii"))
        module.transcript.note(f"sent {leave.form}, in case program entry is open")
        try:
            _probed(module)
        except NoAnswer:
            others = f"it keeps the rate that it detected first, so reset it or give --baud (now {speech.baud})"
            raise NoAnswer(
                f"{silence}  It is also silent during a program or a motion, in binary mode, "
                f"and while its mode register sends answers elsewhere; {others}"
            ) from None
    return module


def _probed(module: Module) -> None:
    """Query a module, and check that its answer is one that this part can give."""
    speech = module.speech
    what = next(what for what, (command, _) in speech.questions.items() if command == speech.probe)
    with suppress(RefusedCommand):
        module.value(what)


# -------------------------------------------------------------------------------------------- parts with an adapter
def _by_adapter(module: Module, baud: int | None, checked: bool | None) -> Module:
    """Query the adapter of a part, and return the module when the adapter answers.

    A line that an earlier host may have left incomplete is ended first.
    """
    speech = module.speech
    strange = b""
    for _ in range(LOOKS):
        module.tidy()
        module.send(speech.wake)
        received = b""
        for received, _ in module.chunks(LOOK_S, speech.seconds(speech.longest(speech.probe), LOOK_S)):
            if speech.is_complete("", received):
                break  # the adapter's answer to it has ended
        try:
            reply = module.once(speech.probe).text
        except NoAnswer as silence:
            strange = silence.received or received or strange
            continue
        if reply == speech.busy or re.fullmatch(speech.questions["adapter"][1], reply):
            return module
        strange = reply.encode("latin-1")
    found = f"received {strange[:40]!r}" if strange else "no characters received"
    raise NoAnswer(
        f"{module.port.where}: no adapter answers {module.speech.probe} at {module.speech.baud} baud: {found}; "
        "allowed: an adapter with the framing of slewline serve --framing; check its power, its port and --baud"
    )


Look = Callable[[Module, "int | None", "bool | None"], Module]
LOOKS_FOR: Mapping[type[Speech], Look] = MappingProxyType(
    {LineSpeech: _by_lines, QuerySpeech: _by_queries, FramedSpeech: _by_adapter}
)
