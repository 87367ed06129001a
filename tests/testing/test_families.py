"""A fixture for every part: a URL where it has a serial line, or else a host on its bus; and ports for all of them."""

from __future__ import annotations

import tempfile
import time

import pytest
import serial

from slewline.chips import PARTS
from slewline.core.datasheet.channel import AdaptiveLine, BusHandshake, HostPort, SerialLine
from slewline.errors import UsageError
from slewline.links.clients.chipset_host import ChipsetHost

BUS = ("cy500", "cy512", "cy525")
CHIPSETS = tuple(part for part in PARTS if part.startswith("mc"))
PROGRAMS = {  # thirty steps
    "cy500": "A\rF 1\rR 5\rS 5\rN 30\rG\r",
    "cy512": "A 0\rF 1\rR 100\rS 200\rN 30\rG\r",
    "cy525": "A 0\rF 10\rR 100\rS 240\rZ 1\rN 30\rG\r",
}


@pytest.fixture
def module(request):
    """The fixture that has the name of a part."""
    return request.getfixturevalue(request.param.replace("-", "_"))


@pytest.mark.parametrize("module", PARTS, indirect=True)
def test_each_part_has_a_fixture_that_runs(module, request):
    part = request.node.callspec.params["module"]
    assert module.chip.sheet.part == part
    sheet = module.chip.sheet
    serial_line = sheet.channel(SerialLine) or sheet.channel(AdaptiveLine)
    if serial_line:
        assert module.url.startswith(f"slewline://{part}?")
    else:
        with pytest.raises(UsageError, match=rf"has no url, .* command it through {module.chip.name}\.host$"):
            _ = module.url
    module.advance("250 ms")
    module.until_idle()
    assert module.now >= 250 * 10**9 and not module.chip.steps().times_ps.size
    assert f"{part} at " in module.report()
    assert isinstance(module.rig.channel, SerialLine | AdaptiveLine | BusHandshake | HostPort)


@pytest.mark.parametrize("module", BUS, indirect=True)
def test_a_part_on_a_bus_is_spoken_to_by_its_host(module, request):
    part = request.node.callspec.params["module"]
    module.host.send(PROGRAMS[part])
    module.until(module.chip.reaches(10))
    assert module.position == 10
    module.until_idle()
    module.assert_steps(30, direction=+1)
    with pytest.raises(AssertionError, match="30 steps found, expected 31"):
        module.assert_steps(31)
    assert [line.split("! ")[1] for line in module.report().splitlines() if "! " in line] == [
        "moves from 0",
        "is at rest at 30",
    ]


@pytest.mark.parametrize("module", CHIPSETS, indirect=True)
def test_each_axis_of_a_chipset_is_queried_for_its_steps(module):
    assert module.ask("GET_VRSN") > 0
    last = module.chip.sheet.axes
    axis = module.host.axis(last)
    for command, value in (("SET_POS", 30), ("SET_VEL", 0x40000), ("SET_ACC", 0x1000)):
        axis.command(command, value)
    axis.command("UPDATE")
    module.until(module.chip.axis(last).reaches(30))
    module.until_idle()
    module.assert_steps(30, direction=+1, axis=last)
    if last > 1:
        module.assert_steps(0, axis=1)


def test_faults_that_take_no_line_are_there_and_the_others_are_refused(cy525, mc1451a):
    with cy525.faults.stuck_switch("step_inhibit", 1):
        cy525.host.send(PROGRAMS["cy525"])
        cy525.advance("100 ms")
        assert cy525.position == 0
    cy525.faults.power_cut(lasting="1 ms")
    cy525.advance("10 ms")
    assert "the supply is off" in cy525.report()
    for module in (cy525, mc1451a):
        with pytest.raises(UsageError, match=r"lost byte: \w+, a \w+, has no serial line"):
            module.faults.lost_byte()


# ---------------------------------------------------------------------------------------------------------------- ports
@pytest.mark.system
@pytest.mark.slewline(on="tcp")
def test_on_tcp_a_bus_is_reached_through_a_uart_and_a_chipset_by_its_registers(cy525, mc1451a):
    with serial.serial_for_url(cy525.url) as port:
        port.write(PROGRAMS["cy525"].encode())
        while cy525.rig.do(lambda: cy525.rig.line.taken) < len(PROGRAMS["cy525"]):
            time.sleep(0.005)  # until they have come, time stands still
        cy525.until(lambda: cy525.position == 30)
    cy525.assert_steps(30)
    with ChipsetHost(*mc1451a.url.rpartition("//")[2].split(":")) as host:
        assert host.query("GET_VRSN") == 0x5C11
    says = r'cy525 on tcp: only the program on the port can command it; for ask\(\), use on="host"'
    with pytest.raises(UsageError, match=says):
        cy525.ask("?")


@pytest.mark.system
@pytest.mark.slewline(on="tcp", framing=True)
def test_with_framing_a_bus_is_read_back(cy512):
    with serial.serial_for_url(cy512.url, timeout=60) as port:
        port.write(b"?\r")
        assert port.read_until(b"\n") == b"? ready\r\n"


@pytest.mark.slewline(on="host", straps={"chs": 0})
def test_a_module_on_a_line_may_have_a_host_as_well(gs_c200s):
    assert gs_c200s.ask("V1") == "V+0"
    gs_c200s.assert_reply("F", "R")


@pytest.mark.slewline(on="url")
def test_a_part_without_a_line_has_no_url(slewline_module):
    with pytest.raises(UsageError, match="cy525 has no serial line"):
        slewline_module("cy525")


@pytest.mark.slewline(on="pty")
def test_a_chipset_has_no_device_file(slewline_module, monkeypatch, tmp_path):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    with pytest.raises(UsageError, match="--pty"):
        slewline_module("mc1451a")
    assert not list(tmp_path.iterdir())
