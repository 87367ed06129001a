"""Bench files: what they furnish, and what they say about mistakes: file, line, key, what is allowed."""

from __future__ import annotations

import gc
import os
import re
import socket
import tomllib
from pathlib import Path

import pytest

import slewline
from slewline.bench import file as file_module
from slewline.bench import load
from slewline.bench.file import BenchFile
from slewline.bench.files.toml import read_toml
from tests.rows import rows

X = '[[chip]]\npart = "cy525"\nname = "x"\n'
Y = '[[chip]]\npart = "cy525"\nname = "y"\n'


@pytest.fixture
def bench_of(tmp_path):
    """A bench from the text of a bench file."""

    def load(*tables, **options):
        path = tmp_path / "bench.toml"
        path.write_text("\n".join(tables))
        return slewline.load(path, **options)

    return load


# ----------------------------------------------------------------------------------------------------------- furnishing
def test_the_example_in_the_docstring_is_a_bench(bench_of, tmp_path):
    (tmp_path / "weld.cy525").write_text("A 7\n")
    text = re.search(r"^    \[bench\].*keep = \"10 s\"", file_module.__doc__, re.DOTALL | re.MULTILINE)[0]
    bench = bench_of(text)
    assert (list(bench.chips), list(bench.parts)) == (["x"], ["not", "host"])
    bench.run("20 ms")
    assert (bench["x"].registers["rate"], bench["x"].pin("abort").level, list(bench.recorded)) == (80, 0, ["x.slew"])


def test_the_file_determines_the_chips(bench_of):
    bench = bench_of(
        '[[chip]]\npart = "cy525"\n',
        '[[chip]]\npart = "CY525"\nname = "z"\ncrystal = "6 MHz"\nstraps = { wait = 0 }',
        "options = { rate = 90, position = 5 }\n",
        '[[chip]]\npart = "cy525"\nname = "b"\nbare = true\n',
    )
    plain, other, bare = bench.chips.values()
    assert (plain.name, plain.crystal_hz, plain.pin("wait").level) == ("cy525", 11_000_000, 1)
    assert (other.crystal_hz, other.pin("wait").level) == (6_000_000, 0)
    assert (other.registers["rate"], other.position) == (90, 5)
    assert (plain.pin("step_inhibit").level, bare.pin("step_inhibit").level) == (0, 1)


def test_scripts_are_queued_and_play(bench_of, tmp_path):
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub" / "y.cy525").write_text("A 9\n")
    bench = bench_of(
        X,
        Y,
        '[[host]]\nchips = ["x"]\nscript = """\nA 7\nR 20"""\n',
        '[[host]]\nname = "other"\nchips = ["y"]\nfile = "sub/y.cy525"\n',
    )
    assert not bench["host"].idle and not bench["other"].idle
    bench.run_until_idle()
    assert (bench["x"].position, bench["x"].registers["rate"], bench["y"].position) == (7, 20, 9)


def test_a_script_may_be_a_list_and_the_only_chip_need_not_be_named(bench_of):
    bench = bench_of(X, '[[host]]\nscript = ["A 7", "R 20"]\n')
    bench.run_until_idle()
    assert (bench["x"].position, bench["x"].registers["rate"]) == (7, 20)


def test_a_host_has_its_delay_and_may_have_no_script(bench_of):
    slow, fast = (bench_of(X, f'[[host]]\ndelay = "{delay}"\n') for delay in ("1 ms", "0 s"))
    for bench in (slow, fast):
        assert bench["host"].idle
        bench["host"].send("A 7\r")
        bench.run_until_idle()
    assert slow.now_ps - fast.now_ps == 4 * 10**9, "1 ms before each of four bytes"


def test_a_host_may_serve_several_chips(bench_of):
    bench = bench_of(X, Y, '[[host]]\nchips = ["x", "y"]\nscript = ["A 1", "@to y", "A 2"]\n')
    bench.run_until_idle()
    assert (bench["x"].position, bench["y"].position) == (1, 2)


@pytest.mark.parametrize(("invert", "level"), [("false", 0), ("true", 1)])
def test_wires(bench_of, invert, level):
    wire = f'[[wire]]\nfrom = "x.programmable_output"\nto = "y.wait"\ninvert = {invert}\n'
    bench = bench_of(X, Y, wire, '[[host]]\nchips = ["x"]\nscript = "C"\n')
    bench.run_until_idle()
    assert bench["y"].pin("wait").level == level


def test_parts_take_their_options_from_their_table(bench_of):
    part = '[[part]]\nkind = "workpieces"\nname = "table"\nto = "x"\npieces = 1\nchange = "3 ms"\n'
    bench = bench_of(X, part)
    levels = []
    bench["x"].pin("wait").net.watch(lambda net: levels.append((bench.now_ps, net.level)))
    bench.run("10 ms")
    assert levels[-1] == (3 * 10**9, 1), "wired, and with the time of the file"
    assert bench["x"].pin("dowhile").level == 1, "the only piece is the last one"


def test_drives_now_and_later(bench_of):
    bench = bench_of(
        X,
        '[[drive]]\npin = "x.wait"\nlevel = 0\n',
        '[[drive]]\npin = "x.wait"\nlevel = 1\nat = "2 ms"\n',
        '[[drive]]\npin = "x.abort"\nlevel = 0\nat = 3_000_000_000\n',
    )
    levels = []
    for name in ("wait", "abort"):
        bench["x"].pin(name).net.watch(lambda net, name=name: levels.append((bench.now_ps, name, net.level)))
    assert bench["x"].pin("wait").level == 0
    bench.run("10 ms")
    assert levels == [(2 * 10**9, "wait", 1), (3 * 10**9, "abort", 0)]


def test_recorders(bench_of):
    bench = bench_of(
        X,
        '[[record]]\npins = ["x.programmable_output"]\nkeep = "1 ms"\n',
        '[[host]]\nscript = ["C", "@wait 5 ms", "B"]\n',
    )
    bench.run_until_idle()
    times, levels = bench.edges("x.programmable_output")
    assert list(levels) == [1] and len(times) == 1, "what is older than a millisecond is forgotten"
    assert len(bench_of(X, "[[record]]\n").recorded) == 23, "all pins, the bus in one"


def test_seed_and_options_of_the_bench(bench_of, tmp_path):
    bench = bench_of("[bench]\nseed = 7\n", X, journal=tmp_path / "j", shuffle=3)
    assert (bench.seed, bench.kernel.shuffle is None) == (7, False)
    assert '"seed":7' in (tmp_path / "j").read_text()


def test_how_long_to_run_is_for_the_command_line(tmp_path):
    path = tmp_path / "b.toml"
    path.write_text('[bench]\nuntil = "2 s"\n' + X)
    assert (BenchFile(path).tables.bench.until, BenchFile(path).tables.bench.timeout) == ("2 s", "60 s")


def test_prepare_is_called_before_the_scripts_are_queued(tmp_path):
    path = tmp_path / "b.toml"
    path.write_text(X + '[[host]]\nscript = "A 7"\n')
    seen = []
    BenchFile(path).load(lambda bench: seen.append((list(bench.parts), bench["host"].idle))).run_until_idle()
    assert seen == [(["host"], True)]


# ------------------------------------------------------------------------------------------------------------- mistakes
BAD = [
    ("[[chip]\n", "bench.toml: not TOML: Expected ']]'"),
    ("a = " + "[" * 5000, "bench.toml: not readable TOML: its brackets are nested too deeply"),
    ("a = 2024-02-30", "bench.toml: not TOML: "),
    ("\n" + "a." * 100_000 + "a = 1", "bench.toml, line 2: a key of more than 32 parts"),
    ("[" + "a . " * 100_000 + "a]", "bench.toml, line 1: a key of more than 32 parts"),
    ("[" + '"a".' * 100_000 + "'a']", "bench.toml, line 1: a key of more than 32 parts"),
    ("x = { " + "a.\t" * 32 + "a = 1 }", "bench.toml, line 1: a key of more than 32 parts"),
    ("[bench]\nseed = " + "9" * 5000, "bench.toml, line 2: a number of more than 100 digits"),
    ("[bench]\nseed = 0x" + "f" * 5000, "bench.toml, line 2: a number of more than 100 digits"),
    ('s = """\n' + '\\"a.' * 100_000, "bench.toml: not TOML: Unterminated string"),
    ("'" * 3 + "a." * 100_000, "bench.toml: not TOML: "),
    ('"' + '\\"' * 100_000, "bench.toml: not TOML: "),
    (X + Y.replace('"y"', '"x"') + "#" + "a." * 100, "line 4: [[chip]] 2: the bench has a 'x' already"),
    ("part = 3", "bench.toml: [part]: found 3; write [[part]], with two brackets"),
    ('[chip]\npart = "cy525"', "line 1: [chip]: found a single table; write [[chip]], with two brackets"),
    (
        "chips = 3",
        "[chips]: unknown key; allowed bench, chip, part, wire, host, serve, drive, record; did you mean chip?",
    ),
    (
        '[[chip]]\n\ncristal = "11 MHz"\npart = "cy525"',
        "line 3: [[chip]] 1, cristal: unknown key; allowed part, name, crystal",
    ),
    (X + '[[chip]]\nname = "y"', "line 4: [[chip]] 2: needs the key part; its keys: part, name, crystal"),
    (X + "crystal = 5.5", 'line 4: [[chip]] 1, crystal: found 5.5; allowed a frequency such as "11 MHz"'),
    (X + 'crystal = "99 MHz"', "line 1: [[chip]] 1: crystal '99 MHz': CY525 takes 1 to 11 MHz"),
    (X + "straps = { abort = 2 }", "line 4: [[chip]] 1, straps: found {'abort': 2}; allowed 0, 1 for a pin"),
    (X + "straps = { bell = 1 }", "line 1: [[chip]] 1: x (cy525) has no pin 'bell'; its pins: io_request"),
    (X + "bare = 1", "line 4: [[chip]] 1, bare: found 1; allowed true, false"),
    (X + "options = { rates = 3 }", "line 1: [[chip]] 1: x: no option 'rates'; its options: stepwise, cold, "),
    (X + "options = { rate = 300 }", "line 1: [[chip]] 1: x: rate 300; allowed 0..255"),
    (X + 'options = { rate = "fast" }', "line 1: [[chip]] 1: x: rate 'fast'; allowed 0..255"),
    (X + 'options = { crystal = "5 MHz" }', "line 4: [[chip]] 1, options: crystal is a key of the [[chip]] table"),
    (X + "options = { self = 1 }", "line 1: [[chip]] 1: x: no option 'self'; its options: stepwise"),
    (X + '[[part]]\nkind = "inverter"\nself = 5', "line 4: [[part]] 1: inverter: no option 'self'; its options: none"),
    (X + X, "line 4: [[chip]] 2: the bench has a 'x' already; give another name"),
    ('[[chip]]\npart = "cy999"', "line 1: [[chip]] 1: no chip 'cy999'; available: cy525"),
    ('[bench]\nseed = "a"', "line 2: [bench] seed: found 'a'; allowed a whole number"),
    ("[bench]\nuntil = 0.5", 'line 2: [bench] until: found 0.5; allowed a time such as "25 us"; text, because'),
    ('[bench]\ntimeout = "-3 s"', "line 2: [bench] timeout: time '-3 s': virtual time does not run backwards"),
    (X + '[[wire]]\nfrom = "x.slew"', "line 4: [[wire]] 1: needs the key to; its keys: from, to, invert"),
    (X + '[[wire]]\nfrom = "x.slew"\nto = "x.bell"', "line 4: [[wire]] 1: x (cy525) has no pin 'bell'"),
    (X + '[[wire]]\nfrom = "x.slew"\nto = "x.vcc"', "line 4: [[wire]] 1: x.vcc (pin 40: +5 V) carries no signal"),
    (X + '[[drive]]\npin = "x.abort"\nlevel = 3', "line 6: [[drive]] 1, level: found 3; allowed 0, 1"),
    (X + '[[drive]]\npin = "abort"\nlevel = 1', "line 4: [[drive]] 1: pin 'abort': give owner and pin"),
    (X + '[[drive]]\npin = "x.abort"\nlevel = 1\nat = 1.5', "line 7: [[drive]] 1, at: found 1.5; allowed a time"),
    (X + '[[record]]\npins = ["x.bell"]', "line 4: [[record]] 1: x (cy525) has no pin 'bell'"),
    (X + '[[record]]\nkeep = "soon"', "line 4: [[record]] 1: time 'soon': expected a number and a unit"),
    (X + '[[part]]\nname = "u"', "line 4: [[part]] 1: needs the key 'kind', such as kind = \"inverter\""),
    (X + '[[part]]\nkind = "uhu"', "line 4: [[part]] 1: no part 'uhu'; available: inverter, and, or"),
    (X + '[[part]]\nkind = "inverter"\nto = 5', "line 4: [[part]] 1: to: found 5; allowed text"),
    (
        X + '[[part]]\nkind = "nand"\ngates = 5',
        "line 4: [[part]] 1: nand: no option 'gates'; its options: inputs",
    ),
    (X + '[[part]]\nkind = "nand"\ninputs = "two"', "line 4: [[part]] 1: "),
    (X + '[[host]]\nfile = "nix.cy525"', "line 5: [[host]] 1, file: "),
    (X + '[[host]]\nchips = ["y"]', "line 5: [[host]] 1, chips: no chip 'y' on the bench; available: x"),
    (X + Y + '[[host]]\nscript = "A 0"', 'line 7: [[host]] 1: no chip named; write chips = ["x"]'),
    (X + "[[host]]\nscript = 5", "line 5: [[host]] 1, script: found 5; allowed text, or a list of lines"),
    (
        X + '[[host]]\nscript = "A 0"\nfile = "a"',
        "line 6: [[host]] 1, file: given together with script; give one of the two",
    ),
    (X + '[[host]]\ndelay = "long"', "line 4: [[host]] 1: time 'long'"),
    (X + '[[host]]\nscript = ["A 0", "@foo"]', "bench.toml, [[host]] 1, script, line 2, column 1: no directive @foo"),
    (
        X + '[[host]]\nscript = "@until bell=1"',
        "bench.toml, [[host]] 1, script, line 1, column 1: x (cy525) has no pin 'bell'",
    ),
]


@pytest.fixture
def collected():
    """Nothing that other tests left is collected in a test: one of the mistakes leaves no stack for that."""
    gc.collect()


@rows(("text", "says"), BAD)
@pytest.mark.usefixtures("collected")
def test_mistakes_are_reported_with_file_line_and_key(bench_of, tmp_path, text, says):
    with pytest.raises((slewline.errors.BenchFileError, slewline.ProgramError)) as raised:
        bench_of(text)
    assert str(raised.value).startswith(str(tmp_path / "bench.toml"))
    assert says in str(raised.value)
    assert len(str(raised.value)) < 700


def test_dots_and_digits_in_text_and_comments_mean_nothing():
    texts = ["a." * 100, "9" * 200, '"""' + "a." * 100, "# " + "a." * 100, "it's " + "a." * 100]
    quotes = {"a": '"', "b": "'", "c": '"' * 3, "d": "'" * 3}
    lines = [f"{key}{n} = {quote}{texts[n]}{quote}" for key, quote in quotes.items() for n in (0, 1)]
    lines += [f"z1 = '{texts[2]}'", f'z2 = "{texts[3]}"', f'z3 = "{texts[4]}"', texts[3], "x." * 31 + "x = 1"]
    found = read_toml("here", "\n".join(lines))
    assert list(found.values())[-4:-1] == [texts[2], texts[3], texts[4]]
    assert found == tomllib.loads("\n".join(lines))


def test_a_message_keeps_place_and_remedy_and_the_number_of_omitted_lines(bench_of, tmp_path):
    texts = []
    for length in (100, 100_000):
        with pytest.raises(slewline.errors.BenchFileError) as raised:
            bench_of(X.replace("cy525", "a" * length))
        texts.append(str(raised.value))
    short, cut = texts
    assert cut.startswith(f"{tmp_path / 'bench.toml'}, line 1: [[chip]] 1: no chip 'aaa")
    assert "aaa'; available: cy525, " in cut and len(cut) < 2100
    assert f" ... ({len(short) + 99_900} characters in all) ... " in cut, "though it was cut before the place was known"


@pytest.mark.parametrize("what", ["host", "wire"])
def test_a_wire_has_a_limited_number_of_pins(bench_of, what):
    tables = {"host": "[[host]]\n", "wire": '[[part]]\nkind = "inverter"\n[[wire]]\nfrom = "x.slew"\nto = "{}.in1"\n'}
    names = ["inverter", *(f"inverter_{n}" for n in range(2, 600))]
    with pytest.raises(slewline.errors.BenchFileError, match=r"pins on one wire; allowed up to 500"):
        bench_of(X, *(tables[what].format(name) for name in names))


def test_the_file_of_a_script_is_named_with_its_line(bench_of, tmp_path):
    (tmp_path / "w.cy525").write_text("A 0\n@foo\n")
    with pytest.raises(slewline.ProgramError) as raised:
        bench_of(X, '[[host]]\nfile = "w.cy525"\n')
    assert str(raised.value).startswith(f"{tmp_path / 'w.cy525'}, line 2, column 1: no directive @foo")


def test_no_script_is_queued_when_another_one_is_refused(bench_of):
    with pytest.raises(slewline.ProgramError):
        bench_of(X, Y, '[[host]]\nchips = ["x"]\nscript = "A 0"\n[[host]]\nchips = ["y"]\nscript = "@foo"\n')


@pytest.mark.parametrize(
    ("name", "data", "says"),
    [
        ("missing.toml", None, "cannot be read: No such file or directory"),
        (".", None, "is a directory; give a regular file"),
        (
            "garbage.toml",
            b"\xff\x01\x00",
            "byte FF in line 1 is not UTF-8 text; save it as UTF-8, or name the right file",
        ),
        ("zero.toml", b"a = 1\n\0", "contains NUL bytes, so it is not text; name the right file"),
        ("wide.toml", "a = 1\n".encode("utf-16"), "wide.toml: text in UTF-16; save it as UTF-8 (Notepad: Save as"),
        ("le.toml", "a = 1\n".encode("utf-16-le"), "le.toml: text in UTF-16; save it as UTF-8"),
        ("be.toml", "a = 1\n".encode("utf-16-be"), "be.toml: text in UTF-16; save it as UTF-8"),
        ("late.toml", b"a = 1\n\n b = \xe4", "byte E4 in line 3 is not UTF-8 text"),
        ("big.toml", b"#" * 10_000_001, "more than 10000000 bytes; check that it is the right file"),
    ],
)
def test_files_that_cannot_be_read(tmp_path, name, data, says):
    if data is not None:
        (tmp_path / name).write_bytes(data)
    with pytest.raises(slewline.errors.BenchFileError, match=re.escape(says)) as raised:
        load(tmp_path / name)
    assert str(raised.value).startswith(str(tmp_path / name))


def test_a_name_that_the_system_refuses():
    with pytest.raises(slewline.errors.BenchFileError, match="cannot be read"):
        load(Path("a\0b"))


def test_keys_in_another_notation_have_a_name_but_no_line(bench_of):
    with pytest.raises(slewline.errors.BenchFileError, match=r"bench\.toml: \[\[chip\]\] 1, crystal: found 5\.5"):
        bench_of('chip = [{ part = "cy525", crystal = 5.5 }]')


# ----------------------------------------------------------------------------------------------- whose files it reads
HOST = '[[host]]\nfile = "{}"\n'


@pytest.fixture
def secret(tmp_path):
    """A file that lies beside the folder of the bench file; returns what the bench file may try."""
    (tmp_path / "secret.txt").write_text("A 1\n")
    folder = tmp_path / "mine"
    (folder / "below").mkdir(parents=True)
    (folder / "link.txt").symlink_to(tmp_path / "secret.txt")
    (folder / "out").symlink_to(tmp_path)
    (folder / "good.txt").write_text("A 9\n")
    (folder / "below" / "good.txt").symlink_to(folder / "good.txt")
    return folder


def outside(folder):
    return ["../secret.txt", str(folder.parent / "secret.txt"), "link.txt", "out/secret.txt", "below/../../secret.txt"]


def made(folder, name):
    (folder / "bench.toml").write_text(X + HOST.format(name))
    return folder / "bench.toml"


def test_a_bench_file_reads_nothing_outside_its_folder(secret):
    for name in outside(secret):
        with pytest.raises(
            slewline.errors.BenchFileError, match=r"line 5: \[\[host\]\] 1, file: found .*outside the folder"
        ):
            slewline.load(made(secret, name))


def test_a_bench_file_reads_its_own_folder_wherever_it_is_started_from(secret, monkeypatch):
    for name in ("good.txt", "below/good.txt", "./below/../good.txt", "out/mine/good.txt", str(secret / "good.txt")):
        for start in (secret, secret.parent, "/"):
            monkeypatch.chdir(start)
            bench = slewline.load(os.path.relpath(made(secret, name)))
            bench.run("10 ms")
            assert bench["x"].position == 9


def test_a_bench_file_reads_anywhere_when_it_may(secret):
    for name in outside(secret):
        bench = slewline.load(made(secret, name), anywhere=True)
        bench.run("10 ms")
        assert bench["x"].position == 1


@pytest.mark.posix
def test_an_irregular_file_is_refused_immediately(secret, monkeypatch):
    os.mkfifo(secret / "fifo")
    (secret / "zero").symlink_to("/dev/zero")
    monkeypatch.chdir(secret)
    with socket.socket(socket.AF_UNIX) as plug:
        plug.bind("plug")  # a path may have some hundred characters at most
        for name, kind in (("fifo", "a FIFO"), ("zero", "a device"), ("plug", "a socket"), ("below", "a directory")):
            with pytest.raises(slewline.errors.BenchFileError, match=f"is {kind}; give a regular file"):
                slewline.load(made(secret, name), anywhere=True)
            with pytest.raises(slewline.errors.BenchFileError, match=f"is {kind}; give a regular file"):
                slewline.load(secret / name)
            with pytest.raises(slewline.errors.BenchFileError, match=f"is {kind}; give a regular file"):
                slewline.replay(secret / name)
    with pytest.raises(slewline.errors.BenchFileError, match="outside the folder"):
        slewline.load(made(secret, "zero"))


def test_an_invalid_name_is_reported_with_its_key(secret):
    (secret / "bench.toml").write_text(X + '[[host]]\nfile = "a\\u0000b"\n')
    with pytest.raises(slewline.errors.BenchFileError, match=r"line 5: \[\[host\]\] 1, file: "):
        slewline.load(secret / "bench.toml")
