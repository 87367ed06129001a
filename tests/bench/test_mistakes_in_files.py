"""Mistakes that come naturally in bench files, each with the end of its answer."""

from __future__ import annotations

import pytest

from slewline.bench.file import BenchFile
from slewline.errors import BenchFileError
from tests.rows import rows

MISTAKES = [  # the file, the end of the answer
    ("[[chip]]\npart = cy525\n", ': not TOML: Invalid value (at line 2, column 8); put text in quotes: part = "cy525"'),
    (
        '[[chip]]\npart = "cy525"\nbare = True\n',
        "Invalid value (at line 3, column 8); write true and false in lower case: bare = true",
    ),
    ('[[chip]]\npart = "cy255"\n', "mc1151a, mc1251a, mc1451a, mc1151a-e, mc1251a-e, mc1451a-e; did you mean cy525?"),
    ("[[chip]]\npart = 525\n", ", line 2: [[chip]] 1, part: found 525; allowed text"),
    (
        '[[chip]]\nname = "x"\n',
        "1: [[chip]] 1: needs the key part; its keys: part, name, crystal, straps, bare, options",
    ),
    ('[chip]\npart = "cy525"\n', ", line 1: [chip]: found a single table; write [[chip]], with two brackets"),
    (
        '[[chips]]\npart = "cy525"\n',
        "key; allowed bench, chip, part, wire, host, serve, drive, record; did you mean chip?",
    ),
    (
        '[[chip]]\npart = "cy525"\nnmae = "x"\n',
        "unknown key; allowed part, name, crystal, straps, bare, options; did you mean name?",
    ),
    (
        '[[chip]]\npart = "cy525"\ncrystal = 11\n',
        "(up to 12 with a finding); CY525 manual, 1984; a bare number is hertz: write '11 MHz'",
    ),
    (
        '[[chip]]\npart = "cy525"\ncrystal = 11.0\n',
        '[[chip]] 1, crystal: found 11.0; allowed a frequency such as "11 MHz", or whole hertz',
    ),
    (
        '[[chip]]\npart = "cy525"\ncrystal = "11"\n',
        "1: frequency '11': expected a number and a unit (hz, khz, mhz), for example '11 MHz'",
    ),
    (
        '[[chip]]\npart = "gs-c200s"\nstraps = { chs = "low" }\n',
        "br0, br1, br2, sel0, sel1, sel2, rec, test, rxd, txpd, enable, home, eot, ui1, ui2, ui3",
    ),
    (
        '[[chip]]\npart = "gs-c200s"\nstraps = { chs = 2 }\n',
        "br0, br1, br2, sel0, sel1, sel2, rec, test, rxd, txpd, enable, home, eot, ui1, ui2, ui3",
    ),
    (
        '[[chip]]\npart = "gs-c200s"\nstraps = { checksum = 0 }\n',
        "rdy, mov, ramp, enable, dir, reset, clock, home, uo1, eot, uo2, ui1, uo3, ui2, ui3",
    ),
    (
        '[[chip]]\npart = "gs-c200s"\nstraps = ["chs"]\n',
        "br0, br1, br2, sel0, sel1, sel2, rec, test, rxd, txpd, enable, home, eot, ui1, ui2, ui3",
    ),
    (
        '[[chip]]\npart = "cy525"\noptions = { rat = 80 }\n',
        "divisor, position; also crystal, straps, bare and name; did you mean rate?",
    ),
    (
        '[[chip]]\npart = "cy525"\noptions = { rate = "fast" }\n',
        ", line 1: [[chip]] 1: cy525: rate 'fast'; allowed 0..255",
    ),
    (
        '[[chip]]\npart = "cy525"\nrate = 80\n',
        "crystal, straps, bare, options; it is an option of the part: options = { rate = 80 }",
    ),
    (
        '[[chip]]\npart = "gs-c200s"\nbaud = 9600\n',
        "3: [[chip]] 1, baud: unknown key; allowed part, name, crystal, straps, bare, options",
    ),
    (
        '[[chip]]\npart = "cy525"\noptions = { crystal = "11 MHz" }\n',
        ", line 3: [[chip]] 1, options: crystal is a key of the [[chip]] table, not an option",
    ),
    (
        '[[chip]]\npart = "cy525"\nname = "my chip"\n',
        ", line 1: [[chip]] 1: name 'my chip': allowed letters, digits and underscores",
    ),
    (
        '[[chip]]\npart = "cy525"\nname = "x"\n[[chip]]\npart = "cy525"\nname = "x"\n',
        ", line 4: [[chip]] 2: the bench has a 'x' already; give another name",
    ),
    (
        '[[chip]]\npart = "my_lab.mx10:Mx10"\n',
        "the import (allow_code=True, --allow-code), or install it with an entry point slewline.chips",
    ),
    (
        "[bench]\nuntil = 2.5\n",
        'allowed a time such as "25 us"; text, because a number with a decimal point would be rounded',
    ),
    (
        '[bench]\nuntil = "2 sec"\n',
        "sec': expected a number and a unit (ps, ns, us, µs, ms, s, min, h), for example '25 us'",
    ),
    (
        "[bench]\ntimeout = 5\n",
        "timeout: time 5: a bare number is picoseconds; write its unit, such as '5 ms' or '5 ps'",
    ),
    ('[bench]\nseed = "x"\n', ", line 2: [bench] seed: found 'x'; allowed a whole number"),
    (
        '[bench]\nuntill = "2 s"\n',
        ", line 2: [bench] untill: unknown key; allowed seed, until, timeout; did you mean until?",
    ),
    (
        '[[chip]]\npart = "cy525"\nname = "x"\n[[part]]\nname = "not"\n',
        ", line 4: [[part]] 1: needs the key 'kind', such as kind = \"inverter\"",
    ),
    (
        '[[chip]]\npart = "cy525"\nname = "x"\n[[part]]\nkind = "invertr"\n',
        "gpib_controller, gpib_interrupts, workpieces, welder; did you mean inverter?",
    ),
    ('[[chip]]\npart = "cy525"\nname = "x"\n[[part]]\nkind = 3\n', ", line 4: [[part]] 1: kind: found 3; allowed text"),
    (
        '[[chip]]\npart = "cy525"\nname = "x"\n[[part]]\nkind = "eeprom"\nto = "x"\nimage = "x.bin"\n',
        "the content itself; pass slewline.read_image('x.bin'), or use the key 'file' in a bench file",
    ),
    (
        '[[chip]]\npart = "cy525"\nname = "x"\n[[part]]\nkind = "eeprom"\nfile = "none.bin"\n',
        ", line 4: [[part]] 1: none.bin cannot be read: No such file or directory",
    ),
    (
        '[[chip]]\npart = "cy525"\nname = "x"\n[[part]]\nkind = "eeprom"\nfile = "../x.bin"\n',
        "file; copy it there, or allow files anywhere (--anywhere, load(path, anywhere=True))",
    ),
    (
        '[[chip]]\npart = "cy525"\nname = "x"\n[[part]]\nkind = "inverter"\nto = "y"\n',
        ", line 6: [[part]] 1, to: the bench has no 'y'; available: x, inverter",
    ),
    (
        '[[chip]]\npart = "cy525"\nname = "x"\n[[part]]\nkind = "uart"\nbaud = "fast"\n',
        "'fast'; allowed 76800, 38400, 19200, 9600, 4800, 2400, 1200, 600, 300, 150, 75, 37.5",
    ),
    (
        '[[chip]]\npart = "cy525"\nname = "x"\n[[wire]]\nfrom = "x.slew"\n',
        ", line 4: [[wire]] 1: needs the key to; its keys: from, to, invert",
    ),
    (
        '[[chip]]\npart = "cy525"\nname = "x"\n[[wire]]\nfrom = "x.slew"\nto = "x.slew"\n',
        ", line 4: [[wire]] 1: wire x.slew to x.slew: both ends are the same pin or bus; give two different ones",
    ),
    (
        '[[chip]]\npart = "cy525"\nname = "x"\n[[wire]]\nfrom = "x.slow"\nto = "x.wait"\n',
        "pulse, ascii_binary, motion_complete, wait, io_select; did you mean slew?",
    ),
    (
        '[[chip]]\npart = "cy525"\nname = "x"\n[[wire]]\nfrom = "slew"\nto = "x.wait"\n',
        ", line 4: [[wire]] 1: pin 'slew': give owner and pin, such as 'x.slew'",
    ),
    (
        '[[chip]]\npart = "cy525"\nname = "x"\n[[wire]]\nfrom = "x.slew"\nto = "y.wait"\n',
        ", line 4: [[wire]] 1: the bench has no 'y'; available: x",
    ),
    (
        '[[chip]]\npart = "cy525"\nname = "x"\n[[wire]]\na = "x.slew"\nb = "x.wait"\n',
        ", line 5: [[wire]] 1, a: unknown key; allowed from, to, invert",
    ),
    (
        '[[chip]]\npart = "cy525"\nname = "x"\n[[host]]\nchips = ["y"]\n',
        ", line 5: [[host]] 1, chips: no chip 'y' on the bench; available: x",
    ),
    (
        '[[chip]]\npart = "cy525"\nname = "x"\n[[host]]\nchips = "x"\n',
        ", line 5: [[host]] 1, chips: found 'x'; allowed a list",
    ),
    (
        '[[chip]]\npart = "cy525"\nname = "x"\n[[host]]\nbaud = 9600\n',
        ", line 4: [[host]] 1: host: baud 9600; x has no serial line",
    ),
    (
        '[[chip]]\npart = "cy525"\nname = "x"\n[[host]]\ndelay = 0.1\n',
        'allowed a time such as "25 us"; text, because a number with a decimal point would be rounded',
    ),
    (
        '[[chip]]\npart = "cy525"\nname = "x"\n[[host]]\nscript = "A 0"\nfile = "a.cy525"\n',
        ", line 6: [[host]] 1, file: given together with script; give one of the two",
    ),
    (
        '[[chip]]\npart = "cy525"\nname = "x"\n[[host]]\nfile = "none.cy525"\n',
        ", line 5: [[host]] 1, file: none.cy525 cannot be read: No such file or directory",
    ),
    (
        '[[chip]]\npart = "cy525"\nname = "x"\n[[host]]\nscript = 3\n',
        ", line 5: [[host]] 1, script: found 3; allowed text, or a list of lines",
    ),
    (
        '[[chip]]\npart = "cy525"\nname = "x"\n[[drive]]\npin = "x.abort"\nlevel = "low"\n',
        ", line 6: [[drive]] 1, level: found 'low'; allowed 0, 1",
    ),
    (
        '[[chip]]\npart = "cy525"\nname = "x"\n[[drive]]\npin = "x.abort"\nlevel = 2\n',
        ", line 6: [[drive]] 1, level: found 2; allowed 0, 1",
    ),
    (
        '[[chip]]\npart = "cy525"\nname = "x"\n[[drive]]\npin = "x.abort"\nlevel = 0\nat = 0.5\n',
        'allowed a time such as "25 us"; text, because a number with a decimal point would be rounded',
    ),
    (
        '[[chip]]\npart = "cy525"\nname = "x"\n[[drive]]\npin = "x.abrt"\nlevel = 0\n',
        "pulse, ascii_binary, motion_complete, wait, io_select; did you mean abort?",
    ),
    (
        '[[chip]]\npart = "cy525"\nname = "x"\n[[drive]]\npin = "abort"\nlevel = 0\n',
        ", line 4: [[drive]] 1: pin 'abort': give owner and pin, such as 'x.abort'",
    ),
    (
        '[[chip]]\npart = "cy525"\nname = "x"\n[[record]]\npins = "x.slew"\n',
        ", line 5: [[record]] 1, pins: found 'x.slew'; allowed a list",
    ),
    (
        '[[chip]]\npart = "cy525"\nname = "x"\n[[record]]\npins = ["x.slow"]\n',
        "pulse, ascii_binary, motion_complete, wait, io_select; did you mean slew?",
    ),
    (
        '[[chip]]\npart = "cy525"\nname = "x"\n[[record]]\nkeep = 10\n',
        "1: time 10: a bare number is picoseconds; write its unit, such as '10 ms' or '10 ps'",
    ),
    (
        '[[chip]]\npart = "cy525"\nname = "x"\n[[serve]]\ntcp = 4.5\n',
        '4.5; allowed HOST:PORT as text, such as "127.0.0.1:4001", or a port of this machine',
    ),
    (
        '[[chip]]\npart = "cy525"\nname = "x"\n[[serve]]\nchips = ["y"]\ntcp = 4001\n',
        ", line 5: [[serve]] 1, chips: no chip 'y' on the bench; available: x",
    ),
    (
        '[[chip]]\npart = "cy525"\nname = "x"\n[[serve]]\nport = 4001\n',
        "[[serve]] 1, port: unknown key; allowed chips, tcp, pty, rfc2217, serial, framing, prologix, over",
    ),
    (
        '[[chip]]\npart = "cy525"\nname = "x"\n[[serve]]\n',
        ", line 4: [[serve]] 1: found 0 ports; give one of tcp, pty, rfc2217, serial",
    ),
]


@rows(("text", "says"), MISTAKES)
def test_a_mistake_is_answered(tmp_path, monkeypatch, text, says):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "t.toml").write_text(text)
    with pytest.raises(BenchFileError) as raised:
        file = BenchFile("t.toml")
        file.served(file.load())
    assert str(raised.value).startswith("t.toml") and says in str(raised.value)
    assert [path.name for path in tmp_path.iterdir()] == ["t.toml"]


def test_a_port_alone_is_one_of_this_machine(tmp_path):
    (tmp_path / "t.toml").write_text('[[chip]]\npart = "cy525"\n[[serve]]\ntcp = 4001\n')
    file = BenchFile(tmp_path / "t.toml")
    assert [(port.kind, port.where) for port in file.served(file.load())] == [("tcp", "4001")]
