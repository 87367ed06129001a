"""Mistakes that come naturally on a command line, each with the end of its answer; all are wrong use: status 2."""

from __future__ import annotations

FILES = {
    "weld.vcd": "$timescale 1 us $end\n",
    "x.dialogue": "{}\n",
    "p.cy525": "A 0\nR 100\nN 40\nG\n",
    "p.txt": "A 0\n",
    "p.cy255": "A 0\n",
    "b.toml": '[[chip]]\npart = "cy525"\n',
    "m.bin": "x",
    "j.jsonl": "",
}
MISTAKES = [  # the line, the end of the answer
    (
        "help nothing",
        "serve, drive, panel, debug, pull, push, compare, decode, proxy, terminal, epics, demo, examples",
    ),
    ("plot p.cy525", "slewline run FILE --plot F.svg draws a run, slewline ramp CHIP ... --plot F.svg a ramp"),
    ("simulate p.cy525", "No such command 'simulate': slewline run FILE"),
    ("emulate cy525", "No such command 'emulate': slewline serve CHIP --tcp 4001"),
    ("list", "No such command 'list': slewline chips lists the chips, slewline examples the examples"),
    ("info cy525", "No such command 'info': slewline describe CHIP"),
    ("assemble p.cy525", "No such command 'assemble': slewline asm FILE"),
    ("check p.cy525", "No such command 'check': slewline lint FILE"),
    ("rnu p.cy525", "No such command 'rnu'. Did you mean 'run'?"),
    (
        "frobnicate",
        "serve, drive, panel, debug, pull, push, compare, decode, proxy, terminal, epics, demo, examples",
    ),
    ("run", "give one of a program, a bench file and --replay JOURNAL"),
    ("run none.cy525", "none.cy525: cannot be read: No such file or directory"),
    ("run none", "none: cannot be read: No such file or directory"),
    ("run p.txt", ".gs-c200, .gs-c200s, .mc1151a, .mc1251a, .mc1451a, .mc1151a-e, .mc1251a-e, .mc1451a-e"),
    ("run p.cy255", ".mc1151a, .mc1251a, .mc1451a, .mc1151a-e, .mc1251a-e, .mc1451a-e; did you mean cy525?"),
    ("run p.cy525 --chip cy255", "mc1151a, mc1251a, mc1451a, mc1151a-e, mc1251a-e, mc1451a-e; did you mean cy525?"),
    (
        "run p.cy525 --bench b.toml",
        "No such option '--bench': a bench file is the FILE itself, slewline run BENCH.toml",
    ),
    ("run p.cy525 --part cy525", "No such option '--part': --chip names the part"),
    (
        "run p.cy525 -o out.vcd",
        "No such option '-o': --vcd, --steps, --plot and --json name what is written, and where",
    ),
    ("run p.cy525 --csv s.csv", "No such option '--csv': --steps F.csv"),
    ("run p.cy525 --jason x", "No such option '--jason'. Did you mean '--json'?"),
    ("run p.cy525 --vcd out.fst", "give a name that ends in .vcd; vcd2fst FILE.vcd FILE.fst makes an FST file of it"),
    (
        "run p.cy525 --vcd out.sr",
        "in .vcd; sigrok-cli -I vcd -i FILE.vcd -o FILE.sr makes a session of PulseView of it",
    ),
    ("run p.cy525 --steps out.xlsx", "out.xlsx: give a name that ends in .csv or .npz"),
    ("run p.cy525 --plot a.gif", "a.gif: give a name that ends in .svg, .png or .pdf"),
    ("run p.cy525 --plot a", "a: give a name that ends in .svg, .png or .pdf"),
    ("run p.cy525 --vcd no/such/a.vcd", "no/such/a.vcd: there is no directory 'no/such'"),
    ("run p.cy525 --pins slew", "--pins: needs --vcd FILE"),
    (
        "run p.cy525 --vcd a.vcd --pins slow",
        "pulse, ascii_binary, motion_complete, wait, io_select; did you mean slew?",
    ),
    (
        "run p.cy525 --vcd a.vcd --timescale 3ns",
        "100 ps, 1 ns, 10 ns, 100 ns, 1 us, 10 us, 100 us, 1 ms, 10 ms, 100 ms, 1 s, 10 s, 100 s",
    ),
    ("run p.cy525 --crystal 11", "frequency '11': expected a number and a unit (hz, khz, mhz), for example '11 MHz'"),
    (
        "run p.cy525 --crystal 50MHz",
        "crystal '50MHz': CY525 takes 1 to 11 MHz (up to 12 with a finding); CY525 manual, 1984",
    ),
    ("run p.cy525 --until 5", "'5': expected a number and a unit (ps, ns, us, µs, ms, s, min, h), for example '25 us'"),
    ("run p.cy525 --until soon", "expected a number and a unit (ps, ns, us, µs, ms, s, min, h), for example '25 us'"),
    ("run p.cy525 --timeout 1.5", "expected a number and a unit (ps, ns, us, µs, ms, s, min, h), for example '25 us'"),
    (
        "run p.cy525 --drive abort",
        "'--drive': 'abort': give pin, level and instant, such as 'abort=0@12 ms' or 'x.abort=1'",
    ),
    (
        "run p.cy525 --drive abort=low",
        "'abort=low': 'low' is no level; levels are 0 (low) and 1 (high), such as 'abort=0'",
    ),
    ("run p.cy525 --drive dowhile=2@3", "'2' is no level; levels are 0 (low) and 1 (high), such as 'dowhile=0@3'"),
    ("run p.cy525 --strap dowhile=2", "'2' is no level; levels are 0 (low) and 1 (high), such as 'dowhile=0'"),
    ("run p.cy525 --drive ready=0", "--drive ready=0: ready is an output; the inputs of the cy525: io_request, reset"),
    ("run b.toml --drive cy525.slew=1", "--drive cy525.slew=1: slew is an output; the inputs of the cy525"),
    ("run p.cy525 --drive abrt=0", "pulse, ascii_binary, motion_complete, wait, io_select; did you mean abort?"),
    (
        "run p.cy525 --drive abort=0@5",
        "'5': expected a number and a unit (ps, ns, us, µs, ms, s, min, h), for example '25 us'",
    ),
    ("ramp cy525 F=40 S=240 --accel '20000 Hz'", "expected steps/s^2, such as '20000 steps/s2'"),
    ("run p.cy525 --strap wait", "give a pin and its level, 0 or 1, such as 'wait=0'"),
    ("run p.cy525 --strap wait=2", "'2' is no level; levels are 0 (low) and 1 (high), such as 'wait=0'"),
    (
        "run p.cy525 --strap chs=0",
        "no pin 'chs'; its inputs: io_request, reset, abort, db0, db1, db2, db3, db4, db5, db6, db7, dowhile, "
        "step_inhibit, prog, ascii_binary, wait, io_select",
    ),
    (
        "run p.cy525 --strap checksum=off",
        "db3, db4, db5, db6, db7, dowhile, step_inhibit, prog, ascii_binary, wait, io_select",
    ),
    ("run p.cy525 --strap slew=1", "cy525: strap slew=1; straps put an input to 0 or 1"),
    ("run p.cy525 --options none.toml", "none.toml: cannot be read: No such file or directory"),
    ("run p.cy525 --memory m.bin", "memory m.bin: a cy525 has no external memory; leave it out"),
    (
        "run p.cy525 --save-memory m.bin",
        "m.bin: --save-memory needs one memory on the bench, which has none; leave it out",
    ),
    ("run p.cy525 --over serial", "host: over='serial'; cy525 (cy525) has these channels: bus"),
    ("run p.cy525 --replay j.jsonl", "give one of a program, a bench file and --replay JOURNAL"),
    ("run --replay none.jsonl", "journal none.jsonl: cannot be read: No such file or directory"),
    ("run p.cy525 --anywhere", "--anywhere needs a bench file"),
    (
        "run p.cy525 --vcd a.vcd --json a.vcd",
        "a.vcd: this command uses that file already; give every file a name of its own",
    ),
    (
        "run b.toml --chip cy525",
        "a bench file names its chips; leave out --chip, --crystal, --over, --strap, --options, --memory",
    ),
    ("asm none.cy525", "none.cy525: cannot be read: No such file or directory"),
    (
        "asm p.cy525 --format intel",
        "value for '--format': 'intel' is not one of 'listing', 'hex', 'bin', ",
    ),
    ("dis p.cy525", "p.cy525: this is a program text, not program bytes; slewline asm makes bytes of it"),
    ("lint none.cy525", "none.cy525: cannot be read: No such file or directory"),
    ("lint p.txt", ".gs-c200, .gs-c200s, .mc1151a, .mc1251a, .mc1451a, .mc1151a-e, .mc1251a-e, .mc1451a-e"),
    ("ramp", "Missing argument 'CHIP': slewline chips lists them"),
    ("ramp cy255 F=3", "mc1151a, mc1251a, mc1451a, mc1151a-e, mc1251a-e, mc1451a-e; did you mean cy525?"),
    ("ramp cy525 F", "'F': give a parameter and its value, such as R=100"),
    ("ramp cy525 F=3", "no value for R (maximum step rate, 0..127), S (acceleration, 255 is steepest, 1..255)"),
    ("ramp cy525 F=3 R=300 S=1", "cy525: R '300'; allowed 0..127, or text such as '4000 steps/s'"),
    ("ramp cy525 F=3 R=127 S=1 X=3", "cy525: no parameter 'X'; there are: F, R, S, Z, ramp_unit, ramp_jumps"),
    ("ramp cy525 F=3 F=4 R=127 S=1", "cy525: F twice; give one value"),
    ("ramp cy525 F=3,4 R=100,127 S=1", "F and R: lists of values; give one list, and a single value for the others"),
    (
        "ramp cy525 F=3 R=127 S=1,2 --time 1s",
        "list of values is not searched; leave out --time, --accel and --steps, or the list",
    ),
    (
        "ramp cy525 F=3 R=127 S=1 --time 1",
        "'1': expected a number and a unit (ps, ns, us, µs, ms, s, min, h), for example '25 us'",
    ),
    (
        "ramp cy525 F=3 R=127 --time 1s --steps 3",
        "no single goal for the ramp; give one of time, acceleration and steps",
    ),
    ("ramp cy525 F=3 R=127 S=1 --plot a.gif", "a.gif: give a name that ends in .svg, .png or .pdf"),
    ("describe", "Missing argument 'CHIP': slewline chips lists them"),
    ("describe cy255", "mc1151a, mc1251a, mc1451a, mc1151a-e, mc1251a-e, mc1451a-e; did you mean cy525?"),
    ("describe cy525 ZZ", "W (WAIT), X (EXECUTE), Z (DIVISOR), + (CW), - (CCW), 0 (COMMAND); did you mean Z?"),
    ("describe mc1451a SET_VELOCITY", "SET_VELOCITY is not a command of the MC1451A; write SET_VEL"),
    ("describe mc1451a GETVRSN", "GETVRSN is not a command of the MC1451A; write GET_VRSN"),
    ("chips --jsn", "No such option '--jsn'. Did you mean '--json'?"),
    ("compare a.vcd", "Missing argument 'MEASURED.vcd'."),
    ("compare none.vcd none.vcd", "none.vcd: cannot be read: No such file or directory"),
    ("serve", "give one of a chip, such as gs-c200s, and --bench FILE"),
    ("serve cy525", "no port given; give one of --tcp, --pty, --rfc2217, --serial"),
    ("serve cy525 --tcp x", "such as 127.0.0.1:4001, or a port of this machine, 4001 (port 0: any free one)"),
    ("serve gs-c200s --tcp 127.0.0.1:99999", "port 99999 is above 65535; expected HOST:PORT"),
    ("serve b.toml --tcp 0", "'b.toml' is a bench file, not CHIP; write:  slewline serve --bench b.toml --tcp 0"),
    ("lint .", "slewline: .: is a directory; name the files in it"),
    ("run weld.vcd --chip cy525", "slewline: weld.vcd: is no program, but a recording; slewline compare MODEL.vcd"),
    (
        "run weld.vcd",
        "slewline: weld.vcd: is no program, but a recording; slewline compare MODEL.vcd MEASURED reads it",
    ),
    ("lint x.dialogue", "slewline: x.dialogue: is no program, but a dialogue; slewline compare DIALOGUE"),
    ("serve cy525 --tcp 99999", "such as 127.0.0.1:4001, or a port of this machine, 4001 (port 0: any free one)"),
    (
        "serve cy525 --tcp 0.0.0.0:4001",
        "address '0.0.0.0:4001': other machines could reach it; add --allow-remote if they may",
    ),
    ("serve cy525 --port 4001", "No such option '--port': --tcp 4001, --serial DEV or --pty LINK"),
    (
        "serve cy525 --tcp 0 --strap checksum=off",
        "db3, db4, db5, db6, db7, dowhile, step_inhibit, prog, ascii_binary, wait, io_select",
    ),
    (
        "serve gs-c200s --tcp 0 --strap checksum=off",
        "test, rxd, txpd, enable, home, eot, ui1, ui2, ui3; the checksum is on chs (high: lines carry a checksum)",
    ),
    ("serve gs-c200s --tcp 0 --strap checksum=0", "ui3; the checksum is on chs (high: lines carry a checksum)"),
    ("serve gs-c200s --tcp 0 --strap baud=9600", "the baud is on br0 (baud rate), br1 (baud rate), br2 (baud rate)"),
    ("serve gs-c200s --tcp 0 --strap cha=0", "ui1, ui2, ui3; did you mean chs?"),
    ("serve gs-c200s --serial m.bin", "m.bin: is no serial port; name a serial port that exists and that you may open"),
    ("drive gs-c200s --tcp 0 --board m.bin", "m.bin: is no serial port; name the serial port of the board"),
    (
        "serve gs-c200s --tcp 0 --option baud=9600",
        'straps set its rate: br0=0, br1=0, br2=0; straps={"br0": 0, ...}, or --strap br0=0',
    ),
    ("serve cy525 --tcp 0 --rfc2217 0", "--tcp and --rfc2217: a chip has one port; leave out all but one"),
    ("serve cy525 --tcp 0 --lockstep --rate 2", "--lockstep follows no clock; leave out --rate"),
    ("serve cy525 --tcp 0 --state d", "--state keeps EEPROMs, and a cy525 has none; leave it out"),
    ("serve --bench none.toml", "none.toml: cannot be read: No such file or directory"),
    ("serve cy525 --bench b.toml", "give one of a chip, such as gs-c200s, and --bench FILE"),
    ("panel --port 80", "No such option '--port': --listen HOST:PORT"),
    ("run --verbose p.cy525", "No such option '--verbose'\n"),
    ("examples nothing", "no example 'nothing'; slewline examples lists them"),
]


def test_a_mistake_is_answered(call, folder, subtests):
    for name, text in FILES.items():
        (folder / name).write_text(text)
    for line, says in MISTAKES:
        with subtests.test(line):
            ran = call(*line.split())
            assert ran.status == 2 and says in ran.err and "Traceback" not in ran.err
            found = {path.name: path.read_text() for path in folder.iterdir()}
            assert found == FILES  # nothing half-written
