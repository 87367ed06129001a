"""slewline:// and the fixtures: the memory beside a chip, from an image, and kept in a file."""

from __future__ import annotations

import pytest

import slewline.testing  # noqa: F401  # pySerial knows slewline:// from now on
from slewline.bench.files.images import write_image
from slewline.errors import BenchFileError, UsageError
from slewline.testing.endpoints import running

serial = pytest.importorskip("serial")
PROGRAM = b"N 5\r+\rG\r0\r"


def opened(url: str) -> serial.SerialBase:
    return serial.serial_for_url(url, timeout=2)


def listing(port: serial.SerialBase, lines: int) -> bytes:
    port.write(b"\r\rY 0\r? M,%d\r" % lines)
    return port.read_until(b"0\r") + b"".join(port.read_until(b"\r") for _ in range(lines))


def test_an_image_is_in_the_url(tmp_path):
    write_image(tmp_path / "p.hex", PROGRAM)
    with opened(f"slewline://cy545b?memory={tmp_path}/p.hex") as port:
        assert listing(port, 4) == b"Y=00000\r" + PROGRAM
        port.write(b"X\r")
        port.sleep(1)
        assert port.chip.position == 5


@pytest.mark.parametrize("name", ["", "name=kept_by_file&"])
def test_a_file_keeps_the_memory(name, tmp_path):
    url = f"slewline://cy545b?{name}store={tmp_path}/x.eeprom"
    with opened(url) as port:
        port.write(b"\r\rO 0A0H\r? O\r")
        assert port.read_until(b"\r") == b"O=00160\r"
        port.rtscts = True  # the EEPROM is slower than the line
        port.write(b"E\r" + PROGRAM + b"Q? Y\r")
        assert port.read_until(b"\r") == b"Y=00010\r"
    with opened(f"slewline://cy545b?store={tmp_path}/x.eeprom") as port:  # another module
        assert listing(port, 4) == b"Y=00000\r" + PROGRAM


@pytest.mark.parametrize("on", ["url", "tcp"])
def test_the_fixtures_take_both(on, tmp_path):
    write_image(tmp_path / "p.bin", PROGRAM)
    module = running("cy545b", on=on, memory=str(tmp_path / "p.bin"), store=str(tmp_path / "x.eeprom"))
    try:
        assert module.ask("? R") == "R=00100"
        assert module.bench["memory"].content.startswith(PROGRAM)
    finally:
        module.close()
    assert PROGRAM in (tmp_path / "x.eeprom").read_bytes()


def test_a_module_without_such_a_memory_refuses_an_image(tmp_path):
    write_image(tmp_path / "p.bin", PROGRAM)
    with pytest.raises(UsageError, match="a gs-c200s has no external memory; leave out this file"):
        opened(f"slewline://gs-c200s?memory={tmp_path}/p.bin")
    with pytest.raises(BenchFileError, match="cannot be read: No such file"):
        opened(f"slewline://cy545b?memory={tmp_path}/none.bin")
