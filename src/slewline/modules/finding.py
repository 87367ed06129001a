"""A module is looked for on a port: at which rate it answers, and whether its lines have checksums.

What is sent is a question that changes nothing.  At another rate than its own a module may take the characters for
others: what they would be at every other rate of a part is no command (tests/modules/test_finding.py).
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
from .module import NOTICE_S, DialogueRecord, Module
from .module_port import ModulePort
from .speech import LineSpeech, QuerySpeech, speech_of
from .spoken import CR, Speech

if TYPE_CHECKING:
    from .raw import RawRecord

LOOK_S = 0.35  # of silence at a rate, after which the next one is tried
FOLLOWS_S = 0.05  # of silence, after which an answer is over, whatever its end is
MOST_HEARD = 1024  # characters of an answer, however long
LOOKS = 2  # at a rate: the first line may only end what the module had got of another one
START_S = 3.0  # after its port was opened, that is, DTR raised, a module may be starting still


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
    say: Callable[[str], object] = lambda _text: None,
) -> Module:
    """Return the module at a port, which has answered a question.

    Args:
        where: the port, as pySerial takes it.
        sheet: of the part.
        baud: its rate; None: it is looked for, where straps set it.
        checked: its lines have checksums; None: it is looked for.
        address: of the module on a line of several; None: none.
        transcript, may_move, say: as for `Module`.
        echo: the line echoes what is sent.
        raw: keeps what goes over the line.

    Raises:
        UsageError: there is no such port, or the part has not what was given; or the line does not echo.
        NoAnswer, DamagedAnswer: nothing answers, or what does is no such part, or has no checksums as `checked` says.
        PortLost: the port is gone.
    """
    speech = speech_of(sheet, baud, checked, address)
    port = ModulePort(where, speech.setting, raw, echo)
    try:
        look = next(look for kind, look in LOOKS_FOR.items() if isinstance(speech, kind))
        module = look(Module(port, speech, transcript, may_move=may_move, say=say), baud, checked)
        _check_deviations(module)
        if echo and not port.echo.seen:
            raise UsageError(f"{where}: what was sent has not come back: this line does not echo; leave out --echo")
        return module
    except (NoAnswer, DamagedAnswer):
        port.close()
        port.check_echo()
        raise
    except BaseException:
        port.close()
        raise


# ---------------------------------------------------------------------------------------------- what answers every line
def _by_lines(module: Module, baud: int | None, checked: bool | None) -> Module:
    """Ask at one rate after the other, with and without checksums."""
    first, begun_s = module.speech, module.port.clock()
    strange: list[str] = []
    rates = [*first.rates] if baud is None else [baud]
    for rate in rates:
        if module.port.clock() < begun_s + START_S:
            rates.append(rate)  # to be asked once more
        speech = _at(first, rate, bool(checked))
        if rate != first.baud or module.speech is not first:
            module.port.change(speech.setting)
        module.speech = speech
        for _ in range(LOOKS):
            heard = _heard(module)
            if checked is None and _has_checksums(speech, heard):
                module.speech = _at(first, rate, True)
                heard = _heard(module)
            if checked and _lacks_checksums(speech, heard) and heard == _heard(module):
                raise DamagedAnswer(
                    f"{module.name}: {speech.probe} with a checksum was answered with {heard!r} at "
                    f"{speech.setting.in_full}, without one: this module has no checksums; leave out --checksum"
                )
            if _is_answer(module.speech, heard) or _of_old_firmware(module):
                module.transcript.note(f"answers at {module.speech.setting}")
                return module
            if heard:
                strange.append(f"{heard[:40]!r} at {rate} baud")
                _check_deviations(module)
            module.port.check_echo()
            if module.port.clock() > begun_s + NOTICE_S:
                goes_on = "other rates are tried" if baud is None else "it is asked again"
                module.notice(f"{strange[-1] if strange else 'nothing'} came so far; {goes_on}")
    raise NoAnswer(_unfound(module, baud, strange))


def _check_deviations(module: Module) -> None:
    """Ask, and see what comes to its end: whether it is an answer of the part that deviates from the sheet.

    Raises:
        DamagedAnswer: it does, twice in the same way.
    """
    speech = module.speech
    seen = ""
    for _ in range(LOOKS):
        module.tidy()
        module.send(speech.framed(speech.probe))
        silence = LOOK_S + 12 * speech.character_s
        heard = b""
        for chunk in module.chunks(silence, speech.seconds(MOST_HEARD, silence), f"the answer to {speech.probe}"):
            heard = chunk.data + module.listen(FOLLOWS_S + 12 * speech.character_s, MOST_HEARD)
            break
        found = deviations(speech, speech.probe, heard)
        if found and found == seen:
            raise DamagedAnswer(
                f"{module.name}: {speech.probe} was answered with {heard[:60]!r} at {speech.setting.in_full}, and that "
                f"is not as in the sheet: {found}"
            )
        if not found:
            return
        seen = found


def _at(speech: Speech, baud: int, checked: bool) -> Speech:
    return speech_of(speech.sheet, baud, checked, speech.address)


def _heard(module: Module) -> bytes:
    """Ask once; return what comes, up to a carriage return."""
    module.tidy()
    module.send(module.speech.framed(module.speech.probe))
    heard, probe = b"", module.speech.probe
    silence = LOOK_S + 12 * module.speech.character_s
    for chunk in module.chunks(
        silence, module.speech.seconds(module.speech.longest(probe), silence), f"the answer to {probe}"
    ):
        heard += chunk.data
        if heard.endswith(CR):
            break
    return heard


def _has_checksums(speech: Speech, heard: bytes) -> bool:
    """Return whether a refusal of a line without a checksum came with one."""
    checked = _at(speech, speech.baud, True)
    with suppress(DamagedAnswer):
        return heard.endswith(CR) and checked.is_garbled(checked.stripped(heard[:-1]))
    return False


def _lacks_checksums(speech: Speech, heard: bytes) -> bool:
    """Return whether a line with a checksum was refused as no command, in an answer without one."""
    plain = _at(speech, speech.baud, False)
    with suppress(DamagedAnswer):
        line = plain.stripped(heard.removesuffix(CR))
        return heard.endswith(CR) and bool(plain.refusal(line)) and not plain.is_garbled(line)
    return False


def _is_answer(speech: Speech, heard: bytes) -> bool:
    """Return whether it is what the question is answered with, or that the module is busy."""
    shape = next(shape for command, shape in speech.questions.values() if command == speech.probe)
    with suppress(DamagedAnswer):
        line = speech.stripped(heard.removesuffix(CR))
        busy = bool(speech.refusal(line)) and not speech.is_garbled(line) and line == speech.busy
        return heard.endswith(CR) and (busy or re.fullmatch(shape, line) is not None)
    return False


def _of_old_firmware(module: Module) -> bool:
    """Ask with the checksums of old firmware, if there are others; return whether that is answered."""
    speech = module.speech
    if not isinstance(speech, LineSpeech) or not speech.checked:
        return False
    kept, speech.kept = speech.kept, 0
    if _is_answer(speech, _heard(module)):
        return True
    speech.kept = kept
    return False


def _unfound(module: Module, baud: int | None, strange: list[str]) -> str:
    speech = module.speech
    rates = f"{baud} baud" if baud else f"{speech.rates[0]} to {speech.rates[-1]} baud"
    part = speech.sheet.part.upper()
    if strange:
        found = f"no {part} answers {speech.probe} at {rates}; what came was {', '.join(dict.fromkeys(strange))}"
        known = "give --chip, and --baud and --checksum if you know them"
        return f"{module.port.where}: {found}; check that it is this part, and this line; {known}"
    others = "" if speech.address else "; a module that shares a line has an address: give --address"
    return (
        f"{module.port.where}: nothing answers {speech.probe} at {rates}, {speech.word}; is the module on, are its "
        f"wires not exchanged (RxD, TxD, ground)?{others}"
    )


# ------------------------------------------------------------------------------------------------ what answers queries
def _by_queries(module: Module, baud: int | None, checked: bool | None) -> Module:
    """Let the part find the rate, and ask; if it is silent, it may be in program entry since another session."""
    speech = module.speech
    (leave,) = speech.sheet.leave
    module.send(speech.wake)
    module.port.pause(4 * speech.character_s)
    try:
        _probed(module)
    except NoAnswer as silence:
        module.send(CR + leave.form.encode("ascii"))
        module.transcript.note(f"sent {leave.form}, should program entry be open")
        try:
            _probed(module)
        except NoAnswer:
            others = f"it keeps the rate that it has found first, so reset it or give --baud (now {speech.baud})"
            raise NoAnswer(
                f"{silence}  It is silent also while a program or a motion is under way, while it is in binary mode, "
                f"and while its mode register sends answers elsewhere; {others}"
            ) from None
    return module


def _probed(module: Module) -> None:
    """Ask; what comes back must be an answer of the part."""
    speech = module.speech
    what = next(what for what, (command, _) in speech.questions.items() if command == speech.probe)
    with suppress(RefusedCommand):
        module.value(what)


# ------------------------------------------------------------------------------------------- what is behind an adapter
def _by_adapter(module: Module, baud: int | None, checked: bool | None) -> Module:
    """Ask whether the part takes commands, behind what ends a line that an earlier host has left unfinished."""
    speech = module.speech
    strange = b""
    for _ in range(LOOKS):
        module.tidy()
        module.send(speech.wake)
        heard = b""
        for heard, _ in module.chunks(LOOK_S, speech.seconds(speech.longest(speech.probe), LOOK_S)):
            if speech.is_complete("", heard):
                break  # what the adapter says to that is over
        try:
            said = module.once(speech.probe).text
        except NoAnswer as silence:
            strange = silence.received or heard or strange
            continue
        if said == speech.busy or re.fullmatch(speech.questions["adapter"][1], said):
            return module
        strange = said.encode("latin-1")
    found = f"what came was {strange[:40]!r}" if strange else "nothing came"
    raise NoAnswer(
        f"{module.port.where}: no adapter answers {module.speech.probe} at {module.speech.baud} baud: {found}; allowed "
        f"an adapter with the framing of slewline serve --framing; is it on, is this its port, and its rate (--baud)?"
    )


Look = Callable[[Module, "int | None", "bool | None"], Module]
LOOKS_FOR: Mapping[type[Speech], Look] = MappingProxyType(
    {LineSpeech: _by_lines, QuerySpeech: _by_queries, FramedSpeech: _by_adapter}
)
