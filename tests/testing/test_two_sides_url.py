"""slewline:// and the fixtures for a chip that finds its rate and has CTS; scripts over both of its sides."""

from __future__ import annotations

import pytest

import slewline
import slewline.testing
from slewline.bench.scripts.script import run_script
from slewline.cli.main import invoke
from slewline.testing.endpoints import running

serial = pytest.importorskip("serial")


def opened(url: str = "slewline://cy545b", **settings: object) -> serial.SerialBase:
    return serial.serial_for_url(url, **{"timeout": 2, **settings})


# ------------------------------------------------------------------------------------------ URL
@pytest.mark.parametrize("part", ["cy545", "cy545b"])
@pytest.mark.parametrize("baud", [600, 9600, 19200])
def test_a_program_finds_the_chip_by_its_url_at_its_own_rate(part, baud):
    with opened(f"slewline://{part}", baudrate=baud) as port:
        port.write(b"\r\r? R\r")
        assert port.read_until(b"\r") == b"R=00100\r"
        assert port.chip.baud == pytest.approx(baud, rel=0.001)
        assert port.bench.findings == []


def test_a_program_that_sends_nothing_first_is_reported():
    with opened() as port:
        port.write(b"? R\r")
        assert port.read_until(b"\r") == b""
        assert [found.code for found in port.bench.findings] == ["not-adapted"]


def test_options_of_the_part_are_in_the_url():
    with opened("slewline://cy545b?fixed_baud=9600&rate_table=27k") as port:
        port.write(b"? S\r")
        assert port.read_until(b"\r") == b"S=00220\r"


def test_cts_is_seen_and_obeyed_by_a_program_that_requests_it():
    with opened(rtscts=True) as port:
        assert not port.cts  # user bit 6 is high
        port.write(b"\r\rO 0A0H\r")
        port.flush()
        port.sleep(0.01)
        assert port.cts
        port.write(b"D 500\r")
        port.sleep(0.1)
        assert not port.cts
        port.write(b"R 1\rR 2\rR 3\r? R\r")
        assert port.read_until(b"\r") == b"R=00003\r"
        assert port.bench.findings == []


def test_a_program_that_does_not_request_it_loses_characters():
    with opened() as port:
        port.write(b"\r\rO 0A0H\rD 500\rR 1\rR 2\r")
        port.sleep(1)
        assert {found.code for found in port.bench.findings} == {"serial-overrun"}
        port.rtscts = True
        assert port.rtscts


def test_a_module_without_cts_has_it_bridged():
    with opened("slewline://gs-c200s") as port:
        assert port.cts and (port.rts is True)


# ------------------------------------------------------------------------------------------ fixtures
@pytest.mark.parametrize("on", ["url", "tcp", pytest.param("pty", marks=pytest.mark.system), "rfc2217"])
def test_a_controller_queries_and_asserts(on):
    module = running("cy545b", on=on)
    try:
        assert module.ask("? R") == "R=00100"
        module.assert_reply("? P", "P=00000000")
        with pytest.raises(AssertionError, match="R=00100"):
            module.assert_reply("? R", "R=00001")
        with pytest.raises(slewline.UsageError, match="has no answer"):
            module.ask("R 5")
    finally:
        module.close()


def test_characters_can_be_lost_in_transit():
    module = running("cy545b")
    module.faults.lost_byte(count=1)
    with serial.serial_for_url(module.url, timeout=1) as port:
        port.write(b"\r\r? R\r")
        assert port.read_until(b"\r") == b""  # one carriage return is missing
    assert "not-adapted" in module.report()
    module.close()


# ------------------------------------------------------------------------------------------ scripts
@pytest.mark.parametrize("over", ["parallel", "serial"])
def test_a_script_uses_either_side_and_prints_the_answers(over):
    bench = slewline.Bench()
    x = bench.add("cy545b", name="x")
    host = bench.host(x, over=over)
    said: list[str] = []
    host.on_event.add(said.append)
    mode = "O 81H" if over == "parallel" else "O 80H"
    run_script(
        bench, host, f"{mode}\nR 99\n? R\n@until usrb0=1\nN 10\n+\nG\n@wait 1 s\n? P\n@bytes 52 20 37 0D\n? R\n@reset\n"
    )
    bench.run_until_idle()
    assert said[:3] == [mode, "R 99", "? R -> R=00099"]
    assert "? P -> P=00000010" in said and "? R -> R=00007" in said
    assert x.registers["rate"] == 100 and bench.findings == []


def test_an_answer_that_goes_elsewhere_is_not_waited_for():
    bench = slewline.Bench()
    x = bench.add("cy545b", name="x")
    flow, line = bench.host(x), bench.host(x, over="serial")
    said: list[str] = []
    for host in (flow, line):
        host.on_event.add(said.append)
    run_script(bench, flow, "? R\nR 5\n")
    bench.run_until_idle()
    assert said == ["? R", "R 5"]
    run_script(bench, line, "O 81H\n? R\n")
    bench.run("10 s")
    assert said[2:] == ["O 81H", "? R -> no answer"]


@pytest.mark.parametrize("line", ["@live R 5", "@verify 0", "@rate 5", "@ask ? R", "@expect 5"])
@pytest.mark.parametrize("over", ["parallel", "serial"])
def test_directives_for_other_channels_are_refused_with_their_line(over, line):
    bench = slewline.Bench()
    host = bench.host(bench.add("cy545b", name="x"), over=over)
    with pytest.raises(slewline.ProgramError, match=r"x \(cy545b\) (is queried by its own commands|takes none)"):
        run_script(bench, host, f"R 5\n{line}\n")


# ------------------------------------------------------------------------------------ the command line, a diagram
@pytest.mark.parametrize("over", ["serial", "parallel", None])
def test_a_program_file_goes_over_either_side(tmp_path, capsys, over):
    path = tmp_path / "shuttle.cy545b"
    path.write_text(("O 81H\n" if over != "serial" else "") + "R 99\n? R\n")
    assert invoke(["run", str(path), *(["--over", over] if over else [])]) == 0
    assert "? R -> R=00099" in capsys.readouterr().out


def test_an_unknown_side_is_reported(tmp_path, capsys):
    path = tmp_path / "shuttle.cy545b"
    path.write_text("R 99\n")
    assert invoke(["run", str(path), "--over", "bus"]) != 0
    assert "has these channels: parallel, serial" in capsys.readouterr().err


def test_a_bench_file_selects_its_side(tmp_path, capsys):
    path = tmp_path / "both.toml"
    lines = [
        "[[chip]]",
        'part = "cy545b"',
        "[[host]]",
        'over = "serial"',
        'script = "R 98"',
        "[[host]]",
        'script = "S 97"',
    ]
    path.write_text("\n".join(lines))
    assert invoke(["run", str(path), "--over", "serial"]) != 0
    assert "leave out --chip, --crystal, --over" in " ".join(capsys.readouterr().err.split())
    assert invoke(["run", str(path)]) == 0
    told = capsys.readouterr().out
    assert "R 98" in told and "S 97" in told


def test_a_diagram_shows_the_characters_of_the_serial_side():
    bench = slewline.Bench()
    host = bench.host(bench.add("cy545b", name="x"), over="serial")
    bench.record("x.rxd", "x.txd")
    assert host.ask("? R") == "R=00100"
    bench.run("5 ms")
    figure = bench.timing_figure(["rxd", "txd"], stop=bench.now_ps, decode=True)
    shown = [text.get_text() for text in figure.axes[0].texts]
    assert shown.count("0") >= 4 and {"?", "R", "=", "1"} <= set(shown)
