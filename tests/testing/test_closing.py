"""What is closed: twice is once, a `with` block closes, and whoever still holds the other end finds out."""

from __future__ import annotations

import ast
import asyncio
from collections.abc import Callable
from contextlib import ExitStack, closing
from pathlib import Path
from threading import Thread
from typing import Any

import pytest
import serial
import serialx

import slewline
import slewline.testing.for_serialx
from slewline.drive.board.rehearsal import TwinPort
from slewline.links.clients.chipset_host import ChipsetHost
from slewline.links.clients.chipset_port import ChipsetPort
from slewline.links.clients.control_client import ControlClient
from slewline.links.lines.pace import Lockstep
from slewline.links.server import Server
from slewline.testing import open_url
from slewline.testing.endpoints import running

PACKAGE = Path(slewline.__file__).parent
Make = Callable[[ExitStack, Path], Any]


# ------------------------------------------------------------------------------------------------------ all that close
def port(kind: str, part: str = "gs-c200s") -> Make:
    """A port of a server."""

    def make(stack: ExitStack, folder: Path) -> Any:
        bench = slewline.Bench()
        server = stack.enter_context(Server(bench, Lockstep(bench)))
        line = server.line(bench.add(part))
        where = str(folder / "link") if kind == "pty" else "127.0.0.1:0"
        return server.control(where) if kind == "control" else getattr(server, kind)(line, where)

    return make


def module(part: str = "gs-c200s", **how: Any) -> Make:
    return lambda _stack, _folder: running(part, **how)


def client(kind: Callable[[str, int], Any], part: str = "mc1451a") -> Make:
    """The other end of the registers of a chip."""

    def make(stack: ExitStack, _folder: Path) -> Any:
        url = stack.enter_context(running(part, on="tcp")).url
        host, number = url.rpartition("/")[2].split(":")
        return kind(host, int(number))

    return make


def server(_stack: ExitStack, _folder: Path) -> Server:
    bench = slewline.Bench()
    return Server(bench, Lockstep(bench))


def drive(_stack: ExitStack, _folder: Path) -> slewline.Drive:
    bench = slewline.Bench()
    return slewline.Drive(bench, bench.add("cy525"), TwinPort(), horizon="300 ms", black_box=False).__enter__()


PUBLIC: dict[str, Make] = {  # by class and kind
    "Controller, URL": module(),
    "Controller, host": module("cy525"),
    "Controller, tcp": module(on="tcp"),
    "Controller, rfc2217": module(on="rfc2217"),
    "Controller, registers": module("mc1451a", on="tcp"),
    "Server": server,
    "TcpPort": port("tcp"),
    "NetPort": port("rfc2217"),
    "RegisterPort": port("tcp", "mc1151a"),
    "Control": port("control"),
    "Serial": lambda _stack, _folder: open_url("slewline://gs-c200s"),
    "Serial, serialx": lambda _stack, _folder: serialx.serial_for_url("slewline://gs-c200s", 9600),
    "ChipsetPort": client(ChipsetPort),
    "ChipsetHost": client(ChipsetHost),
    "Drive": drive,
}
ON_TERMINALS: dict[str, Make] = {"Controller, pty": module(on="pty"), "PtyPort": port("pty")}


def closes_once(one: Any) -> None:
    with one as entered:
        assert entered is one
    one.close()
    one.close()
    assert not getattr(one, "is_open", False)


@pytest.mark.parametrize("name", PUBLIC)
def test_it_is_closed_by_a_block_and_twice(name, tmp_path):
    with ExitStack() as stack:
        closes_once(PUBLIC[name](stack, tmp_path))


@pytest.mark.system
@pytest.mark.posix
@pytest.mark.parametrize("name", ON_TERMINALS)
def test_so_is_a_terminal(name, tmp_path):
    with ExitStack() as stack:
        closes_once(ON_TERMINALS[name](stack, tmp_path))


def test_so_is_a_client_of_the_control_port(tmp_path):
    async def main(control: Any, server: Server) -> None:
        running = asyncio.get_running_loop().run_in_executor(None, server.run)
        async with await ControlClient.connect(control.where) as client:
            await client.request("status")
        await client.close()
        await client.close()
        server.stop()
        await running

    bench = slewline.Bench()
    bench.add("cy525")
    with Server(bench, Lockstep(bench)) as server:
        asyncio.run(main(server.control("127.0.0.1:0"), server))


def test_all_that_the_pages_say_can_be_closed_is_here():
    said = set()
    for page in (PACKAGE.parents[1] / "docs/reference/api").glob("*.md"):
        name = ""
        for line in page.read_text().splitlines():
            if ".. autoclass::" in line:
                name = line.split()[-1].rpartition(".")[2]
            if ":members:" in line and "close" in line.replace(",", " ").split():
                said.add(name)
    assert {"Server", "Drive", "ChipsetHost"} <= said
    assert said <= {name.partition(",")[0] for name in PUBLIC} | {"ControlClient"}
    for name in said - {"ControlClient"}:
        assert name in PUBLIC


def test_every_class_that_closes_in_links_and_testing_is_here_or_inside():
    found = set()
    for room in ("links/ports", "links/clients", "testing"):
        for path in (PACKAGE / room).glob("*.py"):
            for node in ast.walk(ast.parse(path.read_text())):
                if isinstance(node, ast.ClassDef) and {"close", "_shut"} & {
                    each.name for each in node.body if isinstance(each, ast.FunctionDef | ast.AsyncFunctionDef)
                }:
                    found.add(node.name)
    inside = {
        *("Listener", "Threads", "DevicePort"),  # of a port of the machine
        *("KeptTranscript", "UrlEndpoint", "PortEndpoint", "Rig", "Transport"),
        "ControlClient",  # above
    }
    assert found - inside <= {name.partition(",")[0] for name in (*PUBLIC, *ON_TERMINALS)}
    assert inside <= found


# ---------------------------------------------------------------------------------------------- the other end finds out
SETTINGS: dict[str, Any] = {"bytesize": 7, "parity": "O", "stopbits": 2, "timeout": 1}
USES = {
    "read": lambda port: port.read(1),
    "read_until": lambda port: port.read_until(b"\r"),
    "write": lambda port: port.write(b"F\r"),
    "in_waiting": lambda port: port.in_waiting,
    "flush": lambda port: port.flush(),
    "reset_input_buffer": lambda port: port.reset_input_buffer(),
    "reset_output_buffer": lambda port: port.reset_output_buffer(),
    "send_break": lambda port: port.send_break(0.1),
    "timeout": lambda port: setattr(port, "baudrate", 4800),
    "open": lambda port: serial.serial_for_url(port.port),
}


@pytest.mark.parametrize("end", ["close", "unplug"])
def test_a_program_finds_that_its_port_has_gone_whatever_it_does(slewline_module, end):
    module = slewline_module("gs-c200s", straps={"chs": 0})
    with serial.serial_for_url(module.url, 9600, **SETTINGS) as port:
        port.write(b"F\r")
        assert port.read_until(b"\r") == b"R\r"
        module.close() if end == "close" else module.faults.unplugged()
        for name, use in USES.items():
            with pytest.raises(serial.SerialException, match="closed" if end == "close" else "unplugged"):
                use(port)
                pytest.fail(f"{name}: nothing was raised")
    port.close()
    with pytest.raises(serial.SerialException, match="could not open port"):
        port.open()


def test_a_read_that_waits_in_a_thread_ends_with_the_module(slewline_module):
    module = slewline_module("gs-c200s", rate=1)
    raised: list[Exception] = []

    def read() -> None:
        try:
            port.read(1)
        except Exception as error:
            raised.append(error)

    with closing(serial.serial_for_url(module.url, 9600)) as port:
        reader = Thread(target=read)
        reader.start()
        module.close()
        reader.join(30)
    assert isinstance(raised[0], serial.SerialException)


def test_a_module_that_a_test_has_closed_still_reports(slewline_module):
    for on in ("url", "tcp"):
        module = slewline_module("gs-c200s", on=on, straps={"chs": 0})
        module.ask("F")
        module.close()
        assert "> R\\r" in module.report()


def test_time_passes_no_more_for_a_server_that_a_test_has_closed(slewline_module):
    module = slewline_module("gs-c200s", on="tcp")
    module.close()
    with pytest.raises(slewline.errors.SlewlineError, match="the module has been closed"):
        module.advance("1 s")


def test_serialx_in_asyncio_gets_the_error_too(slewline_module):
    module = slewline_module("gs-c200s", straps={"chs": 0})

    async def main() -> None:
        reader, writer = await serialx.open_serial_connection(module.url, 9600)
        module.faults.unplugged()
        with pytest.raises(serialx.SerialException, match="unplugged"):
            await reader.readuntil(b"\r")
        writer.close()

    slewline.testing.aio.run(main())


# ---------------------------------------------------------------------------------------------- a port that comes back
class Host:
    """A program that survives an adapter which is unplugged: it opens the port again until it is back."""

    def __init__(self, url: str, **settings: Any) -> None:
        self.url, self.settings, self.tries = url, settings, 0
        self.port = serial.serial_for_url(url, 9600, **settings)

    def ask(self, line: bytes) -> bytes:
        while True:
            try:
                self.port.write(line + b"\r")
                if answer := self.port.read_until(b"\r"):
                    return answer
            except serial.SerialException:
                pass
            self.open()

    def open(self) -> None:
        self.port.close()
        self.tries += 1
        try:
            self.port.open()
        except serial.SerialException:
            assert self.tries < 1000


def test_a_host_that_survives_an_unplugged_adapter_continues(slewline_module):
    module = slewline_module("gs-c200s", straps={"chs": 0})
    host = Host(module.url, **SETTINGS)
    module.faults.unplugged(at=module.now + 20 * 10**9, lasting="1 s")
    assert [host.ask(b"F") for _ in range(50)] == [b"R\r"] * 50
    assert 10 <= host.tries <= 13  # each look in vain takes 100 ms
    host.port.close()


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")  # socket:// of pySerial, when it closes
@pytest.mark.parametrize("on", ["tcp", pytest.param("pty", marks=[pytest.mark.system, pytest.mark.posix])])
def test_so_it_does_on_a_port_of_the_machine(slewline_module, on):
    module = slewline_module("gs-c200s", straps={"chs": 0}, on=on)
    host = Host(module.url, timeout=5)
    assert host.ask(b"F") == b"R\r"
    where = module.url
    with module.faults.unplugged():
        with pytest.raises(serial.SerialException):
            serial.serial_for_url(where, 9600, timeout=1)
        with pytest.raises(serial.SerialException):
            for _ in range(1000):  # a system buffers what nobody reads any more
                host.port.write(b"F\r")
                if not host.port.read(1):
                    raise serial.SerialException
    assert module.url == where
    assert host.ask(b"F") == b"R\r"
    host.port.close()


def test_a_part_on_a_bus_has_no_port_to_be_unplugged(cy525):
    with pytest.raises(slewline.errors.UsageError, match=r"has no port; it is on a bus"):
        cy525.faults.unplugged()
