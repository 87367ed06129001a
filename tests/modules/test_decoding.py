"""The dialogue on two wires of a recording, in the forms of several instruments, and as sigrok decodes them."""

from __future__ import annotations

import re
import shutil
import subprocess
from functools import cache

import pytest

import slewline
from slewline.bench.memories import put_memory
from slewline.chips import sheet_of
from slewline.cli.main import invoke
from slewline.core.datasheet.channel import AdaptiveLine, SerialLine
from slewline.errors import UnknownName, UsageError
from slewline.modules.decoding import decode_dialogue
from slewline.modules.dialogue import RecordedDialogue
from tests.captures import US, S, Sampled, Wave, dsview_csv, saleae_csv, scope_csv, sigrok_session, sigrok_vcd

LINES = {
    "gs-c200s": ["F", "V1", "Po", "S10", "T100", "R50", "+60", "Px", "Q", "E", "F", "+9", "V1", "S0"],
    "cy545": ["", "", "R 200", "F 10", "S 200", "? R", "A 0", "+", "N 4", "G", "? P", "? N"],
}
FASTEST = {"gs-c200s": 9600, "cy545": 9600}
MHZ = 10**6


@cache
def talk(part, br=(0, 0, 0)):
    """The wires of a model and its host, and the lines that each has sent."""
    sheet = sheet_of(part)
    bench = slewline.Bench()
    straps = {"chs": 0, **{f"br{n}": level for n, level in enumerate(br)}} if part == "gs-c200s" else {}
    x = bench.add(part, name="x", straps=straps)
    put_memory(bench, x, None)
    over = sheet.through(AdaptiveLine).name if sheet.channel(AdaptiveLine) is not None else None
    host = bench.host(x, over=over)
    if over is not None:
        host.heed(False)
    heard = []
    host.on_character.add(lambda each: heard.append(each.byte))
    bench.record("x.rxd", "x.txd")
    bench.run("3 ms")
    said = []
    for line in LINES[part]:
        data = line.encode() + b"\r"
        host.write(data)
        bench.run("150 ms" if part == "cy545" or br == (0, 0, 0) else "4 s")
        said += [("host", data), *(("module", each + b"\r") for each in bytes(heard).split(b"\r")[:-1])]
        heard.clear()
    first = {"TX": int(part == "cy545"), "RX": int(part == "cy545")}
    edges = {name: bench.edges(f"x.{pin}")[0].tolist() for name, pin in (("TX", "rxd"), ("RX", "txd"))}
    return Wave(edges, first, bench.kernel.now), said


FORMS = {
    "sigrok_1.vcd": lambda of: sigrok_vcd(Sampled(of, MHZ)),
    "sigrok_24.vcd": lambda of: sigrok_vcd(Sampled(of, 24 * MHZ)),
    "bare.vcd": lambda of: sigrok_vcd(Sampled(of, 12 * MHZ), comment=False, first=False),
    "saleae.csv": lambda of: saleae_csv(Sampled(of, 2 * MHZ), trigger_ps=S),
    "dsview.csv": lambda of: dsview_csv(Sampled(of, 10 * MHZ)),
    "rigol.csv": lambda of: scope_csv(Sampled(of, 60_000), "rigol"),
    "inverted.vcd": lambda of: sigrok_vcd(Sampled(of.inverted("TX", "RX"), MHZ)),
    "host_inverted.csv": lambda of: saleae_csv(Sampled(of.inverted("TX"), MHZ)),
}


def decoded(path, part, **given):
    return decode_dialogue(slewline.read_waveforms(path), sheet_of(part), "TX", "RX", **given)


@pytest.mark.parametrize("part", LINES)
@pytest.mark.parametrize("form", FORMS)
def test_the_dialogue_is_the_one_sent(tmp_path, part, form):
    of, said = talk(part)
    path = tmp_path / form
    path.write_bytes(FORMS[form](of))
    found = decoded(path, part)
    assert found.damaged == ()
    assert [(each.speaker, each.data) for each in found.dialogue.entries] == said
    assert found.dialogue.header.baud == FASTEST[part]


@pytest.mark.parametrize(("levels", "rate"), [*sheet_of("gs-c200s").through(SerialLine).bauds.items()])
def test_the_rate_is_found(tmp_path, levels, rate):
    of, said = talk("gs-c200s", levels)
    (tmp_path / "one.csv").write_bytes(saleae_csv(Sampled(of, MHZ)))
    found = decoded(tmp_path / "one.csv", "gs-c200s")
    assert (found.dialogue.header.baud, found.damaged) == (rate, ())
    assert [(each.speaker, each.data) for each in found.dialogue.entries] == said


@pytest.mark.parametrize("part", LINES)
def test_a_decoded_dialogue_is_replayed_with_the_model(tmp_path, monkeypatch, capsys, part):
    """Times as well: of two samples of a microsecond, and what the search for the rate of a CY545 takes."""
    monkeypatch.chdir(tmp_path)
    of, said = talk(part)
    (tmp_path / "one.csv").write_bytes(saleae_csv(Sampled(of, MHZ)))
    words = ["decode", "one.csv", "--chip", part, "--host", "TX", "--module", "RX", "--dialogue", "one.dialogue"]
    assert invoke(words) == 0
    printed = capsys.readouterr().out.splitlines()
    assert [line.split(" ms  ")[1] for line in printed] == [
        f"{'>' if who == 'host' else '<'} {data.decode()[:-1]}\\r" for who, data in said
    ]
    assert invoke(["compare", "one.dialogue", "--tolerance", "20 us"]) == 0
    assert RecordedDialogue.read("one.dialogue").header.part == part


def test_a_damaged_character_is_named_with_its_time(tmp_path, capsys):
    """A spike of half a bit in the middle of the last data bit of the host's first character."""
    of, _ = talk("gs-c200s")
    begin, bit = of.edges["TX"][0], S // 9600
    spike = [begin + 15 * bit // 2 - bit // 4, begin + 15 * bit // 2 + bit // 4]
    hurt = Wave({**of.edges, "TX": sorted([*of.edges["TX"], *spike])}, of.first, of.end)
    (tmp_path / "one.csv").write_bytes(saleae_csv(Sampled(hurt, MHZ)))
    found = decoded(tmp_path / "one.csv", "gs-c200s")
    (one,) = found.damaged
    assert (one.signal, one.parity, one.byte) == ("TX", True, ord("F") ^ 1 << 6)
    assert abs(one.at_ps - begin) < 2 * US
    words = ["decode", str(tmp_path / "one.csv"), "--chip", "gs-c200s", "--host", "TX", "--module", "RX"]
    assert invoke(words) == 1
    assert f"TX at {begin // US / 1000:.3f} ms: wrong parity" in capsys.readouterr().err.replace("3 ms", "3.000 ms")


@pytest.mark.parametrize(
    ("rate", "names", "given", "says"),
    [
        (4_000, ("TX", "RX"), {}, r"sampled often enough \(in this file: every 250 µs\); name the correct signals"),
        (MHZ, ("TX", "QX"), {}, "no signal 'QX'"),
        (MHZ, ("TX", "RX"), {"baud": 19200}, "--baud|allowed"),
        (MHZ, ("TX", "RX"), {"baud": 1200}, "characters are damaged; required: the serial wires of a GS-C200S"),
    ],
)
def test_an_invalid_dialogue_is_refused(tmp_path, rate, names, given, says):
    of, _ = talk("gs-c200s")
    (tmp_path / "one.csv").write_bytes(saleae_csv(Sampled(of, rate)))
    with pytest.raises((UsageError, UnknownName), match=says):
        decode_dialogue(slewline.read_waveforms(tmp_path / "one.csv"), sheet_of("gs-c200s"), *names, **given)


def test_silent_wires_have_no_dialogue(tmp_path):
    quiet = Wave({"TX": [], "RX": []}, {"TX": 1, "RX": 1}, S)
    (tmp_path / "one.vcd").write_bytes(sigrok_vcd(Sampled(quiet, MHZ)))
    with pytest.raises(UsageError, match="there are no characters"):
        decoded(tmp_path / "one.vcd", "gs-c200s")


# --------------------------------------------------------------------------------------------- as sigrok decodes them
@pytest.mark.system
@pytest.mark.skipif(shutil.which("sigrok-cli") is None, reason="sigrok-cli is not installed")
@pytest.mark.parametrize(
    ("part", "word"),
    [("gs-c200s", "data_bits=7:parity=odd:stop_bits=2.0"), ("cy545", "data_bits=8:parity=none:stop_bits=1.0")],
)
def test_sigrok_sees_the_same_characters(tmp_path, part, word):
    program = shutil.which("sigrok-cli")
    of, _ = talk(part)
    session = sigrok_session(Sampled(of, MHZ), program, tmp_path / "one.sr")
    names = [each for each in slewline.read_waveforms(session).names]
    found = decode_dialogue(slewline.read_waveforms(session), sheet_of(part), *names)
    assert found.damaged == ()
    inverted = "yes" if part == "gs-c200s" else "no"
    uart = f"uart:rx={names[0]}:tx={names[1]}:baudrate=9600:{word}:format=hex:invert_rx={inverted}:invert_tx={inverted}"
    for kind, who in (("rx-data", "host"), ("tx-data", "module")):
        said = subprocess.run(
            [program, "-i", session, "-P", uart, "-A", f"uart={kind}"],
            check=True, capture_output=True, text=True, timeout=60,
        ).stdout  # fmt: skip
        bytes_of = bytes(int(each, 16) for each in re.findall(r": ([0-9A-F]{2})$", said, re.MULTILINE))
        assert bytes_of == b"".join(each.data for each in found.dialogue.entries if each.speaker == who)
