"""Mistakes of habit, as users of other libraries make them: names that are set, numbers as text, functions that take
something, a condition as a truth value; each with the end of its answer.  More in test_mistakes_in_python.py."""

from __future__ import annotations

import copy
import pickle

import numpy as np
import pytest

import slewline
from slewline import errors
from slewline.links.lines.pace import Lockstep
from slewline.links.server import Server
from slewline.testing import aio
from tests.system.test_mistakes_in_python import World

RAMPS = {
    "cy500": 'slewline.ramp("cy500", R=100, S=10)',
    "cy525": 'slewline.ramp("cy525", F=3, R=127, S=200)',
    "cy545": 'slewline.ramp("cy545", F=10, R=100, S=100)',
    "gs-c200s": 'slewline.ramp("gs-c200s", S=10, T=50, R=10)',
    "mc1451a": 'slewline.ramp("mc1451a", SET_VEL=100000, SET_ACC=100)',
}
MISTAKES = [  # the line, the error, the end of its message
    # ------------------------------------------------------------------------------------------------ what is set
    ("x.abort = 0", "NoSuchAttribute", "x has no 'abort'; it is a pin: x.pin(\"abort\").drive(0), or drive(1)"),
    ("x.rate = 5", "NoSuchAttribute", "a host sends the command that loads it: bench.host(x).send(...)"),
    ("x.speed = 5", "NoSuchAttribute", "x has no 'speed'; x.velocity_at(\"3 ms\"), or x.velocity_at(bench.now)"),
    ('x.crystal = "11 MHz"', "NoSuchAttribute", "x has no 'crystal'; write x.crystal_hz"),
    ('x.program = "A 0"', "NoSuchAttribute", "a host sends it, instruction after instruction: bench.host(x).send(...)"),
    ("x.moving = False", "NoSuchAttribute", "x: moving cannot be set; x.moving is read-only"),
    ("x.registers = {}", "NoSuchAttribute", "a host sends the commands that load them: bench.host(x).send(...)"),
    ('x.registers["rate"] = 5', "NoSuchAttribute", "a host sends the command that loads one: bench.host(x).send(...)"),
    ("x.registers.update(rate=5)", "NoSuchAttribute", "registers cannot be set here; a host sends the command that"),
    ('del x.registers["rate"]', "NoSuchAttribute", "x (cy525): registers cannot be set here"),
    ('x.pins["abort"] = 0', "NoSuchAttribute", 'a pin is driven: x.pin("io_request").drive(0)'),
    ("b.now = 5", "NoSuchAttribute", 'now cannot be set; let time pass: bench.run("1 ms"), or bench.run_to("5 ms")'),
    (
        "b.seed = 1",
        "NoSuchAttribute",
        "seed cannot be set; give it when the bench is made: slewline.Bench(seed=...)",
    ),
    ("b.sedd = 1", "NoSuchAttribute", "bench has no 'sedd' to set; did you mean seed?"),
    ("b.baud = 9600", "NoSuchAttribute", "bench has no 'baud' to set; keep your own data in a variable"),
    ("b.on_finding = print", "NoSuchAttribute", "on_finding cannot be set; add a listener: .add(function)"),
    # -------------------------------------------------------------------------------------- what there is, by name
    ('x.registers["R"]', "UnknownName", "number, slope, rate, firstrate, divisor, position; did you mean rate?"),
    ('x.registers["raet"]', "UnknownName", "x (cy525) has no register 'raet'; its registers: number, slope, rate"),
    (
        'm.axis(2).registers["foo"]',
        "UnknownName",
        "mc1451a (mc1451a) axis 2 has no register 'foo'; its registers: pos,",
    ),
    ('g.registers["S"]', "UnknownName", "did you mean start_stop?"),
    ("x.registers.rate", "NoSuchAttribute", "x (cy525): registers have no attribute 'rate'; write ['rate']"),
    ('x.pins["abrt"]', "UnknownName", "wait, io_select; did you mean abort?"),
    ('x.pin(["abort"])', "UnknownName", "x (cy525) has no pin ['abort']; its pins: io_request"),
    ("x.steps()[10**6]", "NoSuchStep", "steps[1000000]: allowed 0..39, and -1 for the last"),
    ("x.steps()[-41]", "NoSuchStep", "steps[-41]: allowed 0..39, and -1 for the last"),
    ('x.steps("0 s", "1 us")[0]', "NoSuchStep", "steps[0]: there are no steps"),
    ("x.steps()[1.5]", "UsageError", "arrays are steps.times_ps, steps.directions and steps.positions"),
    (
        "x.steps()[x.steps().positions > 3]",
        "UsageError",
        "expected a whole number, or a slice such as [:10]; arrays are",
    ),
    ("x.axis(1.0)", "UnknownName", "x (cy525) has no axis 1.0; its only axis is 1"),
    ("x.deviation(3)", "UsageError", "x: deviation(3): expected a motion, such as x.motions()[0]"),
    # -------------------------------------------------------------------------------------------------------- ramps
    *(
        (f"{ramp}.move('100')", "UsageError", f"{part}: a move of '100' steps; allowed 1..")
        for part, ramp in RAMPS.items()
    ),
    *((f"{ramp}.move(1.5)", "UsageError", f"{part}: a move of 1.5 steps; allowed 1..") for part, ramp in RAMPS.items()),
    *((f"{ramp}.move(0)", "UsageError", f"{part}: a move of 0 steps; allowed 1..") for part, ramp in RAMPS.items()),
    (f"{RAMPS['cy525']}.move(True)", "UsageError", "a move of True steps; allowed 1..65535 (steps, N)"),
    (f"{RAMPS['cy525']}.time", "NoSuchAttribute", "ramp has no 'time'; write ramp.time_ps"),
    (f"{RAMPS['cy525']}.duration", "NoSuchAttribute", "ramp has no 'duration'; write ramp.time_ps"),
    (f"{RAMPS['mc1451a']}.speed", "NoSuchAttribute", "ramp has no 'speed'; ramp.start and ramp.top, in steps/s"),
    (f"{RAMPS['cy525']}.move(9).time", "NoSuchAttribute", "move has no 'time'; write move.time_ps"),
    # ------------------------------------------------------------------------------------------------------- module
    ("slewline.run", "AttributeError", 'x = bench.add("PART"), then bench.run_until_idle()'),
    ("slewline.add", "AttributeError", 'write slewline.Bench().add("PART")'),
    ("slewline.bench_", "AttributeError", "has no attribute 'bench_'; did you mean Bench?"),
    ("slewline.open", "AttributeError", 'write serial.serial_for_url("slewline://PART"), of pySerial'),
    ("slewline.simulate", "AttributeError", "write bench = slewline.Bench()"),
    # -------------------------------------------------------------------------------------------------------- bench
    (
        "slewline.Bench(speed=1)",
        "UsageError",
        "its arguments: seed, journal, shuffle, stores, keep; a chip is put on it",
    ),
    ("slewline.Bench(sed=1)", "UsageError", "did you mean seed?"),
    (
        "slewline.Bench(0, None, None, None, None, 6)",
        "UsageError",
        "Bench(): too many positional arguments; its arguments",
    ),
    ("slewline.Bench(journal=5)", "UsageError", "Bench(journal=5): allowed the name of a file, None"),
    ('slewline.Bench(shuffle="yes")', "UsageError", "allowed a whole number, the seed of the task order, None"),
    (
        'slewline.Bench(stores="dir")',
        "UsageError",
        "allowed a function that takes a name and returns a memory, None",
    ),
    ('b.add("cy525", bare="no")', "UsageError", "add('cy525'): bare 'no'; allowed True, False"),
    ('b.wire("x.abort", "x.slew", invert="no")', "UsageError", "invert 'no'; allowed True, False"),
    ("b.close()", "NoSuchAttribute", "a bench does not need to be closed; a journal does: bench.journal.close()"),
    (
        "b.run_until(lambda b: b.now > 1)",
        "UsageError",
        "missing a required argument: 'b'; the function must take no arguments: lambda: x.position > 40",
    ),
    (
        "b.run_until(x.reaches)",
        "UsageError",
        "run_until(reaches): missing a required argument: 'position'; the function must take no arguments",
    ),
    (
        'b.at("1 s", lambda b: 0)',
        "UsageError",
        "missing a required argument: 'b'; the function must take no arguments: lambda: x.pin('abort').drive(0)",
    ),
    (
        "b.run_until(x.reaches(3) or x.reaches(4))",
        "UsageError",
        "x at position 3: a condition has no truth value; bench.run_until waits for it",
    ),
    ("assert x.reaches(3)", "UsageError", "x at position 3: a condition has no truth value"),
    (
        "b.run_until(x.reaches(3) & x.reaches(4))",
        "UsageError",
        "x at position 3: a condition has no truth value",
    ),
    (
        "mb.run_until(x.reaches(3))",
        "UsageError",
        "run_until(x at position 3): the condition belongs to another bench, which this call does not run",
    ),
    (
        'mb.run_until(x.pin("slew").is_(0) | m.reaches(3))',
        "UsageError",
        "the condition belongs to another bench, which this call does not run",
    ),
    (
        "mb.run_until(x.at_instruction(3))",
        "UsageError",
        "the condition belongs to another bench, which this call does not run",
    ),
    (
        'b.run_until(x.at_instruction(50), timeout="1 s")',
        "Timeout",
        "x at instruction 50, where no instruction begins: no program is stored; the time is",
    ),
    # -------------------------------------------------------------------------------------------------------- hooks
    ("x.on_step", "NoSuchAttribute", "x.on_motion_begin.add(...) reports motions, x.steps() has every step"),
    ("b.on_finding.append(print)", "NoSuchAttribute", "hook has no 'append'; write hook.add(function)"),
    (
        "b.on_finding(print)",
        "UsageError",
        "the hook is called with a listener, <built-in function print>; write .add(...)",
    ),
    ("x.on_finding(lambda found: 0)", "UsageError", "the hook is called with a listener, <function"),
    ("b.on_finding += print", "UsageError", "hook += <built-in function print>; write .add(...)"),
    ("b.on_finding.remove(print)", "UsageError", "it is not a listener; pass the function that was passed to add()"),
    (
        'b.on_finding.add(lambda: 0); h.send("R 300\\r"); b.run_until_idle()',
        "UsageError",
        "too many positional arguments; it is called with 1 argument: Finding",
    ),
    # ----------------------------------------------------------------------------------------------- pins and hosts
    ('x.pin("slew").edges(True)', "UsageError", "x.slew: True edges; allowed 1 or more"),
    (
        'h.live("R 5")',
        "UsageError",
        "live commands need a running program, and x runs none; start the program with run_program(), or use send()",
    ),
    ("h.verify(True)", "UsageError", "host: verify(True, None); allowed groups 0 to 3, and 0 or more bytes"),
    ("h.verify(1.0)", "UsageError", "host: verify(1.0, None); allowed groups 0 to 3, and 0 or more bytes"),
    (
        'h.write("A 0\\r")',
        "UsageError",
        "its arguments: chip, data; host.send(...) sends to the selected chip",
    ),
    ("h.close()", "NoSuchAttribute", "there is nothing to open or close; host.clear() drops the queue"),
    # --------------------------------------------------------------------------- habits of other libraries, once more
    (
        "b.process(lambda: 0)",
        "NoSuchAttribute",
        'bench.at("1 ms", function) calls it at an instant; slewline.testing.aio',
    ),
    ('b.timeout("5 ms")', "NoSuchAttribute", 'bench.run("10 ms"), in asyncio await bench.wait("10 ms")'),
    (
        "b.run(until=1000)",
        "UsageError",
        "its arguments: duration; run_to(time) goes to an instant, run_until(condition)",
    ),
    ('b.wire("x.run")', "UsageError", "its arguments: a, b, invert; two pins, such as bench.wire('x.run', 'y.wait')"),
    ('b.record(["x.slew"])', "UnknownName", "pass the names as separate arguments: bench.record(*names)"),
    ('b.add("encoder")', "UnknownName", "encoder is a part: use bench.part('encoder')"),
    ('b.part("cy525")', "UnknownName", "cy525 is a chip: use bench.add('cy525')"),
    ('b.part("ram", to=x)', "WiringError", "x (cy525) has none; cy545, cy545b have one"),
    ('b.host("x")', "UsageError", "host: 'x'; expected chips of this bench: bench.host(bench['x'])"),
    (
        "b.host(x, baudrate=9600)",
        "UsageError",
        "its arguments: chips, name, delay, baud, line, over; the straps of the chip",
    ),
    ('b.plot("a.svg", figsize=(8, 6))', "UsageError", 'width is "page", "phone" or inches'),
    (
        'b.timing("t.svg", ["slew"], between=["slew falls"])',
        "UsageError",
        '; two edges are a pair in the list: [("x.slew falls", "x.slew rises")]',
    ),
    (
        'b.stream_vcd("s.vcd").close()',
        "NoSuchAttribute",
        'use it in a with statement: with bench.stream_vcd("run.vcd"):',
    ),
    ('s = b.stream_vcd("s.vcd"); b.run("1 ms")', "UsageError", "stream_vcd: use it in a with statement"),
    ('b.stream_vcd("s.txt")', "UsageError", "s.txt: give a name that ends in .vcd"),
    ("h.readline()", "NoSuchAttribute", "host.received has the received data, host.ask(...) waits"),
    ("h.baudrate = 19200", "NoSuchAttribute", "bench.host(x, baud=9600) sets it, host.change_line(...) changes it"),
    ('gh.parity = "odd"', "NoSuchAttribute", "host.change_line(...) changes the format of a serial line"),
    ("h.timeout = 1", "NoSuchAttribute", 'host.ask(..., timeout="5 s") takes one'),
    ("h.change_rate(60)", "Timeout", "the part accepts a rate while the motor slews in an endless motion"),
    ("h.read_position()", "Timeout", "the position is available while the motor steps; at rest, verify(0) reads it"),
    ("h.verify()", "UsageError", "its arguments: group, number, timeout, live; groups are 0 to 3"),
    ("mh.verify(0)", "NoSuchAttribute", "host has no 'verify'; write host.query(\"GET_POS\")"),
    ('mh.live("GET_POS")', "NoSuchAttribute", "a chipset takes commands at any time: host.command(...)"),
    ('x.pin("abort").value = 0', "NoSuchAttribute", "x.abort has no 'value'; write pin.drive(0) or pin.drive(1)"),
    ('x.pin("abort").high = True', "NoSuchAttribute", "x.abort has no 'high'; write pin.drive(0) or pin.drive(1)"),
    ('x.pin("abort").is_active', "NoSuchAttribute", "x.abort has no 'is_active'; pin.level == pin.row.active"),
    ('x.pin("abort").activate()', "NoSuchAttribute", "x.abort has no 'activate'; write pin.drive(pin.row.active)"),
    ('x.pin("run").wait_for_edge()', "NoSuchAttribute", "bench.run_until(pin.edges(1)), or pin.is_(0)"),
    ('x.pin("abort").pulse("10 us")', "UsageError", 'its arguments: level, width, at; such as pin.pulse(0, "10 us")'),
    (
        "x.reaches(3).__await__()",
        "UsageError",
        "a condition cannot be awaited directly; write await bench.until(...)",
    ),
    ("x.steps().times", "NoSuchAttribute", "steps has no 'times'; write steps.times_ps"),
    ("x.motions()[0].start", "NoSuchAttribute", "motion.time_ps, and motion.position where it begins"),
    ("x.deviation()", "UsageError", "for motion in x.motions(): x.deviation(motion)"),
    (
        "h.send('R 300\\r'); b.run_until_idle(); b.findings[0].message",
        "NoSuchAttribute",
        "finding has no 'message'; write finding.text",
    ),
    ('slewline.compare_edges("x.pulse", "x.pulse")', "UsageError", "model 'x.pulse': expected times and levels, as"),
    ('slewline.compare_edges(([], []), ([], []), shift="auto")', "TimeError", '; also allowed: "first", "best"'),
    (
        'slewline.load("[[chip]]\\npart = 5\\n")',
        "BenchFileError",
        "this is the text of a bench file; give the name of a file",
    ),
    ('b.part("ram", to=slewline.Bench().add("cy545b")).content', "UnknownName", "is not a chip or part of this bench"),
    ('mb.part("encoder", to=m, counts="400")', "UsageError", "; allowed 1..1048576; write 400, without quotes"),
    ('mb.part("encoder", to=m).position', "NoSuchAttribute", "encoder has no 'position'; write encoder.counts"),
    (
        'slewline.load("move.cy525")',
        "BenchFileError",
        "move.cy525: a program, judging by its extension, not a bench file",
    ),
    ('slewline.load("move.cy525")', "BenchFileError", 'or on a bench with a host: [[host]], file = "move.cy525"'),
    ('b.record("x.run"); b.edges("x.run")', "NotRecorded", "ms, so it has no edges yet"),
    ('b.record("x.run"); b.edges("x.run")', "NotRecorded", "call bench.record('x.run') before time passes"),
    (
        'b.record("x.run"); b.save_vcd("a.vcd", ["x.run"])',
        "NotRecorded",
        "so it has no edges yet",
    ),
    ("x.verify(0)", "NoSuchAttribute", "x has no 'verify'; a host has it: bench.host(x).verify"),
    ("x.run_program()", "NoSuchAttribute", "a host has it: bench.host(x).run_program"),
    ("m.packet", "NoSuchAttribute", "a host has it: bench.host(mc1451a).packet"),
    ("b.verify(0)", "NoSuchAttribute", "a host has it: bench.host(x).verify, with x = bench.add(...)"),
    ('b.part("ram").content = b""', "NoSuchAttribute", "ram: content cannot be set; use ram.load(image)"),
]


def test_a_mistake_is_answered(subtests, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for line, error, says in MISTAKES:
        with subtests.test(line):
            with pytest.raises(getattr(errors, error, AttributeError)) as raised:
                exec(line, World(slewline=slewline))
            assert says in str(raised.value)
            assert not list(tmp_path.iterdir())


def test_a_step_beyond_the_last_is_an_index_error_so_that_a_loop_over_steps_ends():
    steps = World()["x"].steps()
    assert [step.position for step in steps] == steps.positions.tolist()
    assert errors.NoSuchStep.__mro__.index(IndexError) and steps[np.int64(-1)] == steps[39]


def test_registers_and_pins_otherwise_behave_like_dicts():
    x = World()["x"]
    registers = x.registers
    assert isinstance(registers, dict) and registers.get("R") is None and "R" not in registers
    for other in (
        copy.copy(registers),
        copy.deepcopy(registers),
        pickle.loads(pickle.dumps(registers)),
        registers | {},
    ):
        assert other == registers and type(other) is dict
    with pytest.raises(KeyError):
        x.pins["abrt"]
    assert not hasattr(registers, "rate")


def test_whole_numbers_of_numpy_are_whole_numbers():
    world = World()
    five = np.int64(5)
    assert slewline.ramp("cy525", F=five, R=np.uint8(100), S=200).move(five).steps == 5
    assert slewline.Bench(seed=five).seed == 5 and type(slewline.Bench(seed=five).seed) is int
    assert world["x"].reaches(five).position == 5
    world["mh"].command("SET_POS", five)
    world["mh"].command("UPDATE")
    assert world["mh"].query("GET_POS") == 5
    assert world["h"].verify(np.int64(0)) == b"00040"


def test_a_wait_for_an_instruction_lists_the_existing_ones():
    world = World()
    world["h"].send("E\rP 3\r0\r")
    world["b"].run_until_idle()
    rows = ", ".join(str(row.address) for row in world["x"].program_rows())
    with pytest.raises(
        errors.Timeout, match=f"instruction 50, where no instruction begins: they begin at {rows}; the time is"
    ) as raised:
        world["b"].run_until(world["x"].reaches(3) | world["x"].at_instruction(50), timeout="1 s")
    assert "x at position 3 or x at instruction 50" in str(raised.value)


class Mine(slewline.Bench):
    """A bench of one's own, which keeps what it likes."""

    def __init__(self):
        super().__init__()
        self.motor = self.add("cy525")


def test_custom_benches_and_chips_have_attributes_of_their_own():
    bench = Mine()
    bench.driver = "mine"
    assert (bench.motor.name, bench.driver) == ("cy525", "mine")
    with pytest.raises(errors.NoSuchAttribute, match="seed cannot be set"):
        bench.seed = 5
    cls = type("Own", (slewline.Chip,), {"sheet": type(bench.motor).sheet, "__module__": "my_lab"})
    own = object.__new__(cls)
    own.rate, own.abort, own.speed = 1, 2, 3
    assert (own.rate, own.abort, own.speed) == (1, 2, 3)


def test_waveforms_have_no_items(tmp_path):
    world, name = World(), str(tmp_path / "a.vcd")
    world["x"], world["b"].save_vcd(name)
    with pytest.raises(errors.UsageError, match=r"waveforms cannot be indexed; write waveforms.edges\('x.pulse'\)"):
        slewline.read_vcd(name)["x.pulse"]


def test_a_function_is_not_a_coroutine():
    async def main():
        pass

    with pytest.raises(errors.UsageError, match=r"aio.run\(main\): this is a function; call it: aio.run\(main\(\)\)"):
        aio.run(main)


def test_a_stream_that_is_entered_later_is_one(tmp_path):
    bench = World()["b"]
    streaming = bench.stream_vcd(tmp_path / "a.vcd")
    with streaming:
        bench.run("1 ms")
    bench.run("1 ms")
    assert (tmp_path / "a.vcd").stat().st_size


# --------------------------------------------------------------------------------------------------- what a host leaves
def told(bench, code):
    return [found.text for found in bench.findings if found.code == code]


@pytest.mark.parametrize(
    ("part", "enter", "ends"), [("gs-c200", "P", "E ends it"), ("gs-c200s", "Po", "E or Px ends it")]
)
def test_an_unended_program_is_reported_at_rest_unless_it_has_been_kept(part, enter, ends):
    bench = slewline.Bench()
    host = bench.host(bench.add(part, straps={"chs": 0}))
    for line in (enter, "S10", "T50"):
        host.ask(line)
    bench.run_until_idle()
    bench.run_until_idle()
    (text,) = told(bench, "unfinished")
    assert text.startswith(f"program entry has been open since {enter}: commands are stored, not executed; {ends}")
    host.ask("M")  # the stand-alone way: what has been entered is in the EEPROM
    bench.run_until_idle()
    host.ask("R20")
    bench.run_until_idle()
    assert len(told(bench, "unfinished")) == 2


@pytest.mark.parametrize("part", ["cy500", "cy512", "cy525", "cy545", "cy545b"])
def test_a_program_without_its_q_is_reported_at_rest_once(part):
    bench = slewline.Bench()
    host = bench.host(bench.add(part))
    for line in ("R 80\r", "E\rP 300\r0\r", "P 0\r"):
        host.send(line)
        bench.run_until_idle()
    text = "program entry has been open since E: commands are stored, not executed; Q ends it"
    assert told(bench, "unfinished") == [text]
    host.send("Q")
    bench.run_until_idle()
    host.send("E\rP 5\r")
    bench.run_until_idle()
    assert told(bench, "unfinished") == [text] * 2
    bench.chips[host.chip.name].reset()
    bench.run("100 ms")
    bench.run_until_idle()
    assert told(bench, "unfinished") == [text] * 2 and not bench.chips[host.chip.name].left_over()


def test_a_p_of_a_cy500_that_waits_for_its_g_is_reported_at_rest():
    bench = slewline.Bench()
    host = bench.host(bench.add("cy500"))
    host.send("A\rR 100\rF 10\rP 300\r")
    bench.run_until_idle()
    assert told(bench, "no-go") == ["P 300 is not followed by G; on the CY500 P only sets the target: send G"]
    for line in ("G\r", "P 5\rN 3\r", "P 9\rI\r"):
        host.send(line)
        bench.run_until_idle()
    assert len(told(bench, "no-go")) == 1
    assert slewline.Bench().add("cy500").left_over() == []


@pytest.mark.parametrize("command", ["SET_RATIO 5", "GET_ACTL_POS"])
def test_a_command_that_needs_an_encoder_is_reported_once_for_a_part_without(command):
    for part, codes in (("mc1451a", ["no-encoder"]), ("mc1451a-e", [])):
        bench = slewline.Bench()
        bench.host(bench.add(part)).send(f"{command}\n{command}\n")
        bench.run("5 ms")
        assert [found.code for found in bench.findings] == codes
    name = command.split()[0]
    bench = slewline.Bench()
    bench.host(bench.add("mc1151a")).send(command)
    bench.run("5 ms")
    assert told(bench, "no-encoder") == [
        f"{name} needs an encoder: the mc1151a accepts the command, but ignores it; use the mc1151a-e"
    ]


def test_a_failed_wait_lists_the_settings_without_an_update():
    world = World()
    host = world["mh"]
    for command in ("SET_POS", "SET_VEL"):
        host.command(command, 100)
    with pytest.raises(errors.Timeout, match="\n  no-update: SET_POS, SET_VEL without an update: send UPDATE"):
        host.wait("motion_complete", "10 ms")
    host.command("UPDATE")
    with pytest.raises(errors.Timeout) as raised:
        host.wait("motion_complete", "10 ms")
    assert "no-update" not in str(raised.value)
    host.command("SET_POS", 5)
    host.command("RESET")
    with pytest.raises(errors.Timeout) as raised:
        host.wait("motion_complete", "10 ms")
    assert "no-update" not in str(raised.value)


@pytest.mark.parametrize("command", ["M", "X", "H+", "E", "S10"])
def test_commands_without_effect_on_a_busy_module_are_reported_once_in_a_run(command):
    bench = slewline.Bench()
    host = bench.host(bench.add("gs-c200s", straps={"chs": 0}))
    for line in ("Po", "S10", "T50", "R10", "+90000", "E"):
        host.ask(line)
    assert [host.ask(line) for line in ("V1", "Q", command, command)] == ["B"] * 4
    (text,) = told(bench, "busy")
    assert text.startswith(f"{command} is answered with B and ignored while a program runs; wait until F is answered")


def test_a_server_names_the_chip_whose_uart_only_receives():
    heard = []
    bench = slewline.Bench()
    server = Server(bench, Lockstep(bench), report=heard.append)
    server.line(bench.add("cy525", name="feeder"))
    server.close()
    assert any("the UART of feeder only receives: commands are not answered" in text for text in heard)
