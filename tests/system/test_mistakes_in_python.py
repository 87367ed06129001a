"""Mistakes that come naturally in Python, each with the end of its answer: what is allowed, or what to write."""

from __future__ import annotations

import inspect

import pytest

import slewline
from slewline import errors


class World(dict):
    """Names that the lines use, made when one asks for them: a bench with a CY525 behind it, a chipset, a module."""

    def __missing__(self, name):
        if name not in ("b", "x", "h", "mb", "m", "mh", "gb", "g", "gh"):
            raise KeyError(name)
        part, bench = {"m": "mc1451a", "g": "gs-c200"}.get(name[0], "cy525"), slewline.Bench()
        chip = bench.add(part, name="x" if part == "cy525" else None)
        host, mark = bench.host(chip), name[0] if part != "cy525" else ""
        self.update({f"{mark}b": bench, mark or "x": chip, f"{mark}h": host})
        if not mark:
            bench.record("x.slew", "x.pulse")
            host.send("A 0\rN 40\rG\r")
            bench.run_until_idle()
        return self[name]


MISTAKES = [  # the line, the error, the end of its message
    ('x.pin("step")', "UnknownName", "motion_complete, wait, io_select; did you mean pulse?"),
    ('m.pin("step")', "UnknownName", "did you mean pulse1?"),
    ('g.pin("direction")', "UnknownName", "did you mean dir?"),
    (
        'slewline.Drive(mb, m.axis(1), "twin")',
        "UsageError",
        "position 0, at rest>: expected a chip, found an axis of one; give the chip, and axis=1",
    ),
    (
        'slewline.Drive(gb, g, "twin", inputs="A1=home")',
        "UsageError",
        "inputs 'A1=home': expected board pins and their chip pins, such as {'A1': 'home'}",
    ),
    (
        'b.plot("a.svg", start="50 ms", stop="20 ms")',
        "UsageError",
        "start 50 ms, stop 20 ms: give a stop after the start",
    ),
    ('slewline.Drive(gb, g, "twin", inputs={"home": "A1"})', "UsageError", "the pin of the board comes first: A1=home"),
    ('slewline.Drive(gb, g, "twin", outputs={"uo1": "D2"})', "UsageError", "the pin of the board comes first: D2=uo1"),
    ('slewline.Drive(gb, g, "twin", horizon=100)', "TimeError", "horizon: time 100: a bare number is picoseconds"),
    ('slewline.Drive(gb, g, "twin", enable_hold="60")', "TimeError", "enable_hold: time '60': expected a number and"),
    (
        'slewline.Drive(gb, g, "twin", horizen="1 s")',
        "UsageError",
        "Drive(): got an unexpected keyword argument 'horizen'",
    ),
    ('slewline.Drive(gb, g, "twin", horizen="1 s")', "UsageError", "clock, wait; did you mean horizon?"),
    ('h.ask("V 0", to="x")', "UsageError", "its arguments: command, timeout; host.to(x) selects one of several chips"),
    ('gh.ask("V1", to="x")', "UsageError", "its arguments: command, timeout; host.to(x) selects one of several chips"),
    ('mh.ask("GET_POS", to="x")', "UsageError", "command, timeout, axis; host.to(x) selects one of several chips"),
    ("b.host([x])", "UsageError", "expected chips of this bench, one argument each: bench.host(*chips)"),
    ('b.part("stepper", x)', "UsageError", "allowed letters, digits and underscores; a neighbour is to=x"),
    (
        'b.part("stepper", to=x, motor={"like": "AS1010", "inertia": 80})',
        "UsageError",
        "inertia 80; allowed up to 1 kg m2",
    ),
    (
        'b.part("stepper", to=x, motor="like AS1010, inertia 80 kg m2")',
        "UsageError",
        "so write the unit, such as '68 g cm2'",
    ),
    ('b.part("stepper", to=x, load={"inertia": 68})', "UsageError", "a number alone is in kg m2, so write the unit"),
    ('b.part("stepper", to=x, load={"mass": 2, "lead": 5})', "UsageError", "lead 5; allowed up to 1 m; a number alone"),
    (
        'b.part("stepper", to=x, load={"torque": -300})',
        "UsageError",
        "torque -300; allowed up to 100 N m; a number alone",
    ),
    ('b.part("stepper", to=x, load={"friction": 10})', "UsageError", "at 1 A: check the units of the load"),
    ("x.slew", "NoSuchAttribute", "x has no 'slew'; it is a pin: x.pin(\"slew\")"),
    ("x.velocity", "NoSuchAttribute", "x has no 'velocity'; x.velocity_at(\"3 ms\"), or x.velocity_at(bench.now)"),
    ("x.speed", "NoSuchAttribute", "x has no 'speed'; x.velocity_at(\"3 ms\"), or x.velocity_at(bench.now)"),
    ('x.send("A 0\\r")', "NoSuchAttribute", "x has no 'send'; bench.host(x).send(...)"),
    ("x.move(100)", "NoSuchAttribute", "x has no 'move'; a host sends the command: bench.host(x).send(...)"),
    (
        "b.remove(x)",
        "NoSuchAttribute",
        "bench has no 'remove'; nothing can be removed from a bench: make a new one, slewline.Bench()",
    ),
    ('h.sendline("N 10")', "NoSuchAttribute", "has no 'sendline'; write host.send(...)"),
    ('x.pin("abort").set_level(1)', "NoSuchAttribute", "x.abort has no 'set_level'; pin.drive(0) or pin.drive(1)"),
    (
        'slewline.Bench("cy525")',
        "UsageError",
        "expected a whole number, the random seed; add() puts a chip on a bench",
    ),
    ('b.on_finding.add("print")', "UsageError", "expected a function, which is called at each event"),
    ('x.write("A 0\\r")', "NoSuchAttribute", "x has no 'write'; bench.host(x).send(...)"),
    ('x.query("V 0")', "NoSuchAttribute", "x has no 'query'; bench.host(x).ask(...)"),
    ("x.rate", "NoSuchAttribute", "x has no 'rate'; it is a register: x.registers[\"rate\"]"),
    ("x.wait", "NoSuchAttribute", "x has no 'wait'; it is a pin: x.pin(\"wait\")"),
    ("x.part", "NoSuchAttribute", "x has no 'part'; write x.sheet.part"),
    ("x.status", "NoSuchAttribute", "x has no 'status'; write x.waiting"),
    ('x.plot("a.svg")', "NoSuchAttribute", "x has no 'plot'; bench.plot(...) draws its signals"),
    ("x.crystal", "NoSuchAttribute", "x has no 'crystal'; write x.crystal_hz"),
    (
        'x.edges("slew")',
        "NoSuchAttribute",
        "x has no 'edges'; bench.record() before time passes, then bench.edges(\"x.PIN\")",
    ),
    (
        "x.run_until_idle()",
        "NoSuchAttribute",
        "x has no 'run_until_idle'; time passes on the bench: bench.run_until_idle()",
    ),
    (
        "x.position = 0",
        "NoSuchAttribute",
        "counts it; a host sends the command that loads or clears it: bench.host(x).send(...)",
    ),
    ('x.pin("slow")', "UnknownName", "pulse, ascii_binary, motion_complete, wait, io_select; did you mean slew?"),
    (
        "x.pin(3)",
        "UnknownName",
        "direction, programmable_output, pulse, ascii_binary, motion_complete, wait, io_select",
    ),
    ("x.axis(2)", "UnknownName", "x (cy525) has no axis 2; its only axis is 1"),
    ('x.axis("x")', "UnknownName", "x (cy525) has no axis 'x'; its only axis is 1"),
    ('x.pin("slew").set(0)', "NoSuchAttribute", "x.slew has no 'set'; pin.drive(0) or pin.drive(1)"),
    (
        'x.pin("slew").level = 0',
        "NoSuchAttribute",
        "x.slew: level cannot be set: it is the state of the wire; write pin.drive(0)",
    ),
    ('x.pin("slew").high()', "NoSuchAttribute", "x.slew has no 'high'; pin.drive(1) drives it, pin.level reads it"),
    ('x.pin("slew").value', "NoSuchAttribute", "x.slew has no 'value'; write pin.level"),
    ('x.pin("slew").toggle()', "NoSuchAttribute", "x.slew has no 'toggle'; write pin.pulse(1, \"10 us\")"),
    ('x.pin("slew").drive("low")', "UsageError", "x.slew: level 'low'; allowed 0, 1 (release() releases the pin)"),
    ('x.pin("slew").drive(2)', "UsageError", "x.slew: level 2; allowed 0, 1 (release() releases the pin)"),
    ('x.pin("abort").drive(0, at="0 ms")', "UsageError", "x.abort: 0 ps is in the past; the time is 136.046909 ms"),
    (
        'x.pin("abort").drive(0, at=5)',
        "TimeError",
        "time 5: a bare number is picoseconds; write its unit, such as '5 ms' or '5 ps'",
    ),
    (
        'x.pin("abort").drive(0, at=0.5)',
        "TimeError",
        "text such as '0.5 s', bench.now, or an integer number of picoseconds; a float would be rounded",
    ),
    (
        'x.pin("abort").pulse(1, 10)',
        "TimeError",
        "time 10: a bare number is picoseconds; write its unit, such as '10 ms' or '10 ps'",
    ),
    ('x.pin("vcc").drive(1)', "WiringError", "x.vcc (pin 40: +5 V) carries no signal"),
    ('x.pin("slew").is_("low")', "UsageError", "x.slew: level 'low'; allowed 0, 1"),
    ('x.pin("slew").edges(0)', "UsageError", "x.slew: 0 edges; allowed 1 or more"),
    (
        'x.steps("60 ms", "10 ms")',
        "TimeError",
        "from 60 ms to 10 ms: the window ends before it begins; give an earlier start, or a later end",
    ),
    (
        'x.motions("60 ms", "10 ms")',
        "TimeError",
        "from 60 ms to 10 ms: the window ends before it begins; give an earlier start, or a later end",
    ),
    (
        'x.marks("2 s", "1 s")',
        "TimeError",
        "from 2 s to 1 s: the window ends before it begins; give an earlier start, or a later end",
    ),
    (
        "x.steps(0.5)",
        "TimeError",
        "text such as '0.5 s', bench.now, or an integer number of picoseconds; a float would be rounded",
    ),
    (
        'x.steps("10 sec")',
        "TimeError",
        "sec': expected a number and a unit (ps, ns, us, µs, ms, s, min, h), for example '25 us'",
    ),
    ('x.position_at("99 s")', "UsageError", "x: 99 s is in the future; the time is 136.046909 ms"),
    (
        "x.velocity_at(0.01)",
        "TimeError",
        "text such as '0.01 s', bench.now, or an integer number of picoseconds; a float would be rounded",
    ),
    ('x.reaches("40")', "UsageError", "x: position '40'; allowed 0..65535"),
    ("x.reaches(1 << 40)", "UsageError", "x: position 1099511627776; allowed 0..65535"),
    (
        "x.at_instruction(-1)",
        "UsageError",
        "x: instruction at -1; allowed 0..59, the addresses of a program, or none for any instruction",
    ),
    ('x.power("off")', "UsageError", "x: power('off'); allowed True, False"),
    (
        'b.add("cy255")',
        "UnknownName",
        "mc1151a, mc1251a, mc1451a, mc1151a-e, mc1251a-e, mc1451a-e; did you mean cy525?",
    ),
    (
        'b.add("CY-525")',
        "UnknownName",
        "mc1151a, mc1251a, mc1451a, mc1151a-e, mc1251a-e, mc1451a-e; did you mean cy525?",
    ),
    (
        'b.add("motor")',
        "UnknownName",
        "cy545b, gs-c200, gs-c200s, mc1151a, mc1251a, mc1451a, mc1151a-e, mc1251a-e, mc1451a-e",
    ),
    ("b.add(525)", "UsageError", "add(525): expected a part number such as 'cy525', or the class of a chip"),
    (
        'b.add("cy525", rat=80)',
        "UsageError",
        "divisor, position; also crystal, straps, bare and name; did you mean rate?",
    ),
    ('b.add("cy525", rate=800)', "UsageError", "cy525: rate 800; allowed 0..255"),
    ('b.add("cy525", rate="fast")', "UsageError", "cy525: rate 'fast'; allowed 0..255"),
    (
        'b.add("gs-c200s", baud=9600)',
        "UsageError",
        'straps set its rate: br0=0, br1=0, br2=0; straps={"br0": 0, ...}, or --strap br0=0',
    ),
    (
        'b.add("cy525", crystal=11)',
        "UsageError",
        "(up to 12 with a finding); CY525 manual, 1984; a bare number is hertz: write '11 MHz'",
    ),
    (
        'b.add("cy525", crystal="11")',
        "TimeError",
        "frequency '11': expected a number and a unit (hz, khz, mhz), for example '11 MHz'",
    ),
    (
        'b.add("cy525", crystal=11e6)',
        "TimeError",
        "frequency 11000000.0: expected text such as '11 MHz', or an integer number of hertz",
    ),
    (
        'b.add("cy525", straps={"ascii": 0})',
        "UnknownName",
        "direction, programmable_output, pulse, ascii_binary, motion_complete, wait, io_select",
    ),
    (
        'b.add("cy525", straps=["wait"])',
        "UsageError",
        "cy525: straps ['wait']; expected pins with levels, such as {\"io_request\": 0}",
    ),
    (
        'b.add("cy525", straps={"wait": "high"})',
        "UsageError",
        "cy525: strap wait='high'; a strap sets an input to 0 or 1",
    ),
    ('b.add("cy525", name="x")', "UsageError", "the bench has a 'x' already; give another name"),
    ('b.add("cy525", name="my chip")', "UsageError", "name 'my chip': allowed letters, digits and underscores"),
    ("b.host()", "UsageError", "host: no chip given; name one: bench.host(x)"),
    ('b.host("x")', "UsageError", "host: 'x'; expected chips of this bench"),
    ("b.host(x, baud=9600)", "UsageError", "host: baud 9600; x has no serial line"),
    ('b.host(x, over="serial")', "UsageError", "host: over='serial'; x (cy525) has these channels: bus"),
    (
        'b.part("uat")',
        "UnknownName",
        "gpib_device, gpib_controller, gpib_interrupts, workpieces, welder; did you mean uart?",
    ),
    ('b.part("inverter", to="y")', "UnknownName", "the bench has no 'y'; available: x, host"),
    (
        'b.part("switch")',
        "UsageError",
        "switch: this switch needs a shaft; name its owner: on=motor or on='its name'",
    ),
    ('b.part("inverter", on=x)', "UsageError", "inverter: this inverter is not mounted on a shaft; leave out on="),
    ('b.part("uart", speed=9600)', "UsageError", "uart: no option 'speed'; its options: baud, bits, parity, stop"),
    (
        'b.part("uart", baud="fast")',
        "UsageError",
        "'fast'; allowed 76800, 38400, 19200, 9600, 4800, 2400, 1200, 600, 300, 150, 75, 37.5",
    ),
    (
        'b.part("eeprom", to=x, image="x.bin")',
        "UsageError",
        "the content itself; pass slewline.read_image('x.bin'), or use the key 'file' in a bench file",
    ),
    (
        'b.part("prom", to=x, image="prog.hex")',
        "UsageError",
        "content itself; pass slewline.read_image('prog.hex'), or use the key 'file' in a bench file",
    ),
    (
        'b.part("eeprom", size=1000)',
        "UsageError",
        "eeprom: size 1000; allowed 2048, 4096, 8192, 16384, 32768, 65536, None",
    ),
    (
        'b.part("inverter", to=x)',
        "WiringError",
        "a part of kind inverter has no standard wiring; connect in1, out with bench.wire",
    ),
    ('b.wire("x.slew", "x.slew")', "WiringError", "x.slew to x.slew: both ends are the same pin or bus; give"),
    ('b.wire("x.slew", "slew")', "UnknownName", "pin 'slew': give owner and pin, such as 'x.slew'"),
    ('b.wire("x.slew", "y.wait")', "UnknownName", "the bench has no 'y'; available: x, host"),
    (
        'b.wire("x.db", "x.wait")',
        "WiringError",
        "wire x.db to x.wait: a bus of eight wires does not fit a single pin; wire bus to bus",
    ),
    ('b.wire("x.vcc", "x.wait")', "WiringError", "x.vcc (pin 40: +5 V) carries no signal; leave it unconnected"),
    (
        'b.connect("x.slew", "x.wait")',
        "UsageError",
        "a part and a list of chips, such as [x, y]; pins are joined by bench.wire('x.slew', 'x.wait')",
    ),
    ('b.pin("slew")', "UnknownName", "pin 'slew': give owner and pin, such as 'x.slew'"),
    ("b.pin(3)", "UnknownName", "pin 3: give owner and pin, such as 'x.io_request'"),
    ('b["y"]', "UnknownName", "the bench has no 'y'; available: x, host"),
    ("b[0]", "UnknownName", "the bench has no 0; available: x, host"),
    ("b.x", "NoSuchAttribute", "bench has no 'x'; chips and parts are found by their names: bench[\"x\"]"),
    ("b.cy525", "NoSuchAttribute", "bench has no 'cy525'; a chip is put on it: x = bench.add(\"cy525\")"),
    ('b.send("A 0\\r")', "NoSuchAttribute", "bench has no 'send'; bench.host(x).send(...), with x = bench.add(...)"),
    ('b.query("V 0")', "NoSuchAttribute", "bench has no 'query'; bench.host(x).ask(...), with x = bench.add(...)"),
    ("b.sleep(1)", "NoSuchAttribute", "bench has no 'sleep'; write bench.run(\"10 ms\")"),
    ("b.time", "NoSuchAttribute", "bench has no 'time'; bench.now, or bench.now_ps"),
    (
        'b.save("run.vcd")',
        "NoSuchAttribute",
        "bench has no 'save'; bench.save_vcd(\"run.vcd\"), save_csv or save_steps",
    ),
    ('b.draw("a.svg")', "NoSuchAttribute", "bench has no 'draw'; write bench.plot(\"run.svg\")"),
    ("b.steps", "NoSuchAttribute", "bench has no 'steps'; it belongs to a chip: x.steps, with x = bench.add(...)"),
    ("b.run(1)", "TimeError", "time 1: a bare number is picoseconds; write its unit, such as '1 ms' or '1 ps'"),
    (
        "b.run(0.5)",
        "TimeError",
        "text such as '0.5 s', bench.now, or an integer number of picoseconds; a float would be rounded",
    ),
    (
        'b.run("1")',
        "TimeError",
        "'1': expected a number and a unit (ps, ns, us, µs, ms, s, min, h), for example '25 us'",
    ),
    (
        'b.run("1 sec")',
        "TimeError",
        "sec': expected a number and a unit (ps, ns, us, µs, ms, s, min, h), for example '25 us'",
    ),
    ('b.run("-1 ms")', "TimeError", "time '-1 ms': virtual time does not run backwards; give 0 or more"),
    (
        'b.run_to("1 ms")',
        "UsageError",
        "run_to: 1 ms is in the past; the time is 136.046909 ms; run() takes a duration",
    ),
    (
        'b.run_until("slew")',
        "UsageError",
        "run_until('slew'): expected a condition such as x.reaches(40), or a function",
    ),
    (
        "b.run_until(x.position == 40)",
        "UsageError",
        "run_until(True): expected a condition such as x.reaches(40), or a function",
    ),
    (
        "b.run_until(x.reaches(3), timeout=5)",
        "TimeError",
        "time 5: a bare number is picoseconds; write its unit, such as '5 ms' or '5 ps'",
    ),
    (
        'b.run_until_idle("soon")',
        "TimeError",
        "expected a number and a unit (ps, ns, us, µs, ms, s, min, h), for example '25 us'",
    ),
    ('b.at("1 ms", print)', "UsageError", "at: 1 ms is in the past; the time is 136.046909 ms"),
    ('b.at("1 s", "print")', "UsageError", "at 1 s: 'print'; expected a function"),
    ('b.record("slew")', "UnknownName", "pin 'slew': give owner and pin, such as 'x.slew'"),
    ('b.record("x.slow")', "UnknownName", "pulse, ascii_binary, motion_complete, wait, io_select; did you mean slew?"),
    (
        'b.record(keep="long")',
        "TimeError",
        "expected a number and a unit (ps, ns, us, µs, ms, s, min, h), for example '25 us'",
    ),
    ('b.edges("x.wait")', "NotRecorded", "x.wait is not recorded; call bench.record('x.wait') before time passes"),
    (
        'b.edges("x.slew", "2 s", "1 s")',
        "TimeError",
        "from 2 s to 1 s: the window ends before it begins; give an earlier start, or a later end",
    ),
    ('b.quantity("x.speed")', "UnknownName", "no quantity 'x.speed'; available: x.velocity, x.position"),
    ("b.figure(ax=3)", "UsageError", "ax: np.int64(3); expected matplotlib axes, such as those of plt.subplots()"),
    (
        'b.figure(cursors=["99 s"])',
        "UsageError",
        "cursors: 99 s is outside the picture, 985 µs to 136.046909 ms; give start or stop too",
    ),
    (
        'b.figure(pins=["x.wait"])',
        "NotRecorded",
        "x.wait is not recorded; call bench.record('x.wait') before time passes",
    ),
    ('b.figure(axes="y")', "UnknownName", "axes: no axis 'y'; allowed x, or numbers from 1"),
    ("b.figure(axes=7)", "UnknownName", "axes: no axis 7; allowed x, or numbers from 1"),
    ('b.figure(parts="motor")', "UnknownName", "parts: no quantity 'motor'; available: none"),
    (
        "b.figure(runs=[b])",
        "UsageError",
        "x (cy525), host; 136.046909 ms>]; expected benches by name, such as {'fast': other}",
    ),
    (
        'b.figure(runs={"a": 3})',
        "UsageError",
        "runs: 'a': expected a bench, or steps such as those of read_vcd(path).steps('pulse')",
    ),
    (
        'b.figure(start="1 s", stop="2 s")',
        "UsageError",
        "ms; call bench.run() first, or give start and stop in the past",
    ),
    ('b.figure(width="wide")', "UsageError", 'width=\'wide\'; allowed "page", "phone", or 3 to 40 inches'),
    ('b.plot("a.gif")', "UsageError", "a.gif: give a name that ends in .svg, .png or .pdf"),
    ('b.plot("a")', "UsageError", "a: give a name that ends in .svg, .png or .pdf"),
    ('b.plot("no/such/a.svg")', "UsageError", "no/such/a.svg: there is no directory 'no/such'"),
    (
        'b.save_vcd("out.fst")',
        "UsageError",
        "give a name that ends in .vcd; vcd2fst FILE.vcd FILE.fst converts it to FST",
    ),
    (
        'b.save_vcd("out.vcd", timescale="3 ns")',
        "UsageError",
        "100 ps, 1 ns, 10 ns, 100 ns, 1 us, 10 us, 100 us, 1 ms, 10 ms, 100 ms, 1 s, 10 s, 100 s",
    ),
    ('b.save_csv("out.xlsx")', "UsageError", "out.xlsx: give a name that ends in .csv"),
    ('b.save_steps("out.xlsx")', "UsageError", "out.xlsx: give a name that ends in .csv or .npz"),
    ('b.save_npz("out.csv")', "UsageError", "out.csv: give a name that ends in .npz"),
    (
        "b.readings([])",
        "UsageError",
        'readings: no instants given; give at least one, such as bench.readings(["10 ms", "20 ms"])',
    ),
    ('b.readings("99 s")', "UsageError", "99 s is in the future; the time is 136.046909 ms"),
    (
        'b.timing("a.svg", between="t14")',
        "UsageError",
        "between='t14': expected a list of pairs of edges, or of symbols such as 't14'",
    ),
    (
        'b.timing("a.svg", between=[("slew falls",)])',
        "UsageError",
        "between ('slew falls',): expected two edges, or the symbol of a time in the data sheet",
    ),
    ('b.check_timing("x")', "UsageError", "check_timing('x'): expected a list of names of chips, such as ['x']"),
    ('h.query("V 0")', "NoSuchAttribute", "host has no 'query'; write host.ask(...)"),
    (
        "h.position",
        "NoSuchAttribute",
        "host has no 'position'; the chip has the position: x.position, with x = bench.add(...)",
    ),
    ("h.read(3)", "NoSuchAttribute", "host has no 'read'; host.received has the received data, host.ask(...) waits"),
    ('h.run("1 s")', "NoSuchAttribute", "host has no 'run'; the bench runs time: bench.run_until_idle()"),
    ("h.send(3)", "UsageError", "host: 3; expected text, bytes, or a list of numbers 0 to 255"),
    ('h.send("Größe\\r")', "UsageError", "host: 'ö' at character 3 is not ASCII; give bytes for raw values"),
    (
        'h.ask("A 0")',
        "UsageError",
        "host: 'A 0' has no answer; ask() is for 'V 0', 'V 1', 'V 2', 'V 3'; use send() for other commands",
    ),
    ("h.verify(77)", "UsageError", "host: verify(77, None); allowed groups 0 to 3, and 0 or more bytes"),
    ('h.to("y")', "UnknownName", "host has no chip 'y'; it serves x"),
    ("mh.set_pos(1000)", "NoSuchAttribute", "host has no 'set_pos'; write host.command(\"SET_POS\", position)"),
    (
        "mh.axis(1).set_pos(1000)",
        "NoSuchAttribute",
        "host.axis(1) has no 'set_pos'; write host.axis(1).command(\"SET_POS\", position)",
    ),
    ("mh.axis(1).GET_POS", "NoSuchAttribute", "host.axis(1) has no 'GET_POS'; write host.axis(1).query(\"GET_POS\")"),
    ("mh.axis(1).position", "NoSuchAttribute", "host.axis(1) has no 'position'; the chip has it: x.axis(1).position"),
    ("mh.axis(5)", "UsageError", "host: axis 5; allowed 1..4 for mc1451a (mc1451a)"),
    ('mh.axis("x")', "UsageError", "host: axis 'x'; allowed 1..4 for mc1451a (mc1451a)"),
    ('mh.command("SET_POSITION", 3)', "UnknownName", "SET_POSITION is not a command of the MC1451A; write SET_POS"),
    ('mh.command("SET_POS")', "UsageError", "SET_POS takes position, not 0 values"),
    (
        'mh.command("SET_POS", 1.5)',
        "UsageError",
        "position 1.5: allowed a whole number, -1073741824..1073741823 (command reference)",
    ),
    (
        'mh.command("SET_POS", 1 << 40)',
        "UsageError",
        "SET_POS position 1099511627776: allowed -1073741824..1073741823 (command reference)",
    ),
    (
        'mh.query("SET_POS")',
        "UsageError",
        "host: SET_POS returns nothing, so it cannot be queried; send it with command()",
    ),
    ('mh.wait("ready")', "UnknownName", "positive_limit, negative_limit, command_error, motor_on, axis_on, in_motion"),
    ("mb.host(m)", "WiringError", "host: mc1451a has a host on this channel already; use bench['host']"),
    ('gh.ask("V1\\r\\n")', "UsageError", "host: command 'V1\\r\\n'; expected one command without a carriage return"),
    ('gh.query("V1")', "NoSuchAttribute", "host has no 'query'; write host.ask(...)"),
    ("gb.host(g)", "WiringError", "host: host is on the line of gs_c200 already; a line can have only one host"),
    (
        "slewline.CY525",
        "AttributeError",
        "has no attribute 'CY525'; a chip is put on a bench: slewline.Bench().add(\"cy525\")",
    ),
    (
        "slewline.GSC200S",
        "AttributeError",
        "has no attribute 'GSC200S'; a chip is put on a bench: slewline.Bench().add(\"gs-c200s\")",
    ),
    ("slewline.Benc", "AttributeError", "module 'slewline' has no attribute 'Benc'; did you mean Bench?"),
    ('slewline.load("none.toml")', "BenchFileError", "none.toml cannot be read: No such file or directory"),
    (
        'slewline.replay("none.jsonl")',
        "BenchFileError",
        "journal none.jsonl cannot be read: No such file or directory",
    ),
    (
        'slewline.ramp("cy525", F=3)',
        "UsageError",
        "no value for R (maximum step rate, 0..127), S (acceleration, 255 is steepest, 1..255)",
    ),
    (
        'slewline.ramp("cy525", F=3, R=300, S=1)',
        "UsageError",
        "cy525: R 300; allowed 0..127, or text such as '4000 steps/s'",
    ),
    (
        'slewline.ramp("cy525", f_=3)',
        "UnknownName",
        "cy525: no parameter 'f_'; available: F, R, S, Z, ramp_unit, ramp_jumps; did you mean F?",
    ),
    (
        'slewline.ramp("cy255", F=3)',
        "UnknownName",
        "mc1151a, mc1251a, mc1451a, mc1151a-e, mc1251a-e, mc1451a-e; did you mean cy525?",
    ),
    (
        'slewline.find_ramps("cy525", F=3, R=100)',
        "UsageError",
        "the ramp needs exactly one goal: time, acceleration or steps",
    ),
    (
        'slewline.find_ramps("cy525", F=3, R=100, time=1)',
        "TimeError",
        "time 1: a bare number is picoseconds; write its unit, such as '1 ms' or '1 ps'",
    ),
    ('slewline.read_vcd("none.vcd")', "UsageError", "none.vcd cannot be read: No such file or directory"),
    ('slewline.read_image("none.bin")', "BenchFileError", "none.bin cannot be read: No such file or directory"),
    (
        'slewline.write_image("a.bin", "text")',
        "UsageError",
        "a.bin: image 'text'; expected bytes, such as the result of read_image()",
    ),
    (
        'slewline.Bench(journal="no/such/j.jsonl")',
        "BenchFileError",
        "journal no/such/j.jsonl: No such file or directory; give a file that can be written",
    ),
]


def test_a_mistake_is_answered(subtests, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for line, error, says in MISTAKES:
        with subtests.test(line):
            with pytest.raises(getattr(errors, error, AttributeError)) as raised:
                exec(line, World(slewline=slewline))
            assert says in str(raised.value)
            assert not list(tmp_path.iterdir())  # nothing half-written


def calls_with_keywords():
    """Yield the functions of slewline, and the calls on a bench and on hosts that take more than a value."""
    for name in slewline.__all__:
        one = getattr(slewline, name)
        if inspect.isfunction(one) or name in ("Bench", "Drive"):
            yield name, one
    world = World()
    bench = world["b"]
    for name in type(bench)._for_users:
        one = getattr(bench, name)
        if inspect.ismethod(one):
            yield f"bench.{name}", one
    for host in ("h", "mh", "gh"):
        yield f"{host}.ask", world[host].ask


@pytest.mark.parametrize("call", [pytest.param(call, id=name) for name, call in calls_with_keywords()])
def test_an_unknown_keyword_is_answered_with_the_existing_ones(call):
    names = [
        name
        for name, of in inspect.signature(call).parameters.items()
        if of.kind not in (of.VAR_KEYWORD, of.VAR_POSITIONAL)
    ]
    with pytest.raises(errors.UsageError) as raised:
        call(nonsense_=1)
    text = str(raised.value)
    assert "its arguments: " in text
    assert all(name in text.partition("its arguments: ")[2] for name in names)


def test_names_that_are_not_there_trouble_nobody():
    world = World()
    x, b, h = world["x"], world["b"], world["h"]
    for one, names in ((x, ("slew", "send")), (b, ("send", "x")), (h, ("query",)), (x.pin("slew"), ("set",))):
        assert [name for name in names if hasattr(one, name) or name in dir(one)] == []
        assert getattr(one, names[0], None) is None
        assert not hasattr(type(one), names[0])  # so that mocks do not have them either
    assert hasattr(x, "wait") is False and "wait" in x.pins
