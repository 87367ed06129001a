"""Programs with asyncio, in the tests of anyio: streams on a socket, serialx, pyserial-asyncio."""

import asyncio

import pytest
import serial

import slewline.testing.for_serialx  # noqa: F401 (from now on serialx knows the URLs)

pytestmark = [pytest.mark.anyio, pytest.mark.slewline(straps={"chs": 0})]


@pytest.fixture
def anyio_backend():
    return "asyncio"


@pytest.mark.slewline(on="tcp")
async def test_streams_on_a_socket(gs_c200s):
    host, port = gs_c200s.url.removeprefix("socket://").split(":")
    reader, writer = await asyncio.open_connection(host, int(port))
    for line, answer in ((b"F\r", b"R\r"), (b"V1\r", b"V+0\r")):
        writer.write(line)
        assert await reader.readuntil(b"\r") == answer
    writer.close()
    await writer.wait_closed()


async def test_two_tasks_with_serialx(slewline_module):
    serialx = pytest.importorskip("serialx")

    async def ask(module):
        reader, writer = await serialx.open_serial_connection(module.url, 9600, byte_size=7, parity="O", stopbits=2)
        writer.write(b"V1\r")
        answer = await reader.readuntil(b"\r")
        writer.close()
        await writer.wait_closed()
        return answer

    modules = [slewline_module("gs-c200s") for _ in range(3)]
    assert await asyncio.gather(*map(ask, modules)) == [b"V+0\r"] * 3


async def test_a_cancelled_read_leaves_the_port_usable(gs_c200s):
    serialx = pytest.importorskip("serialx")
    reader, writer = await serialx.open_serial_connection(gs_c200s.url, 9600, byte_size=7, parity="O", stopbits=2)
    with pytest.raises(TimeoutError):
        await asyncio.wait_for(reader.readuntil(b"\r"), 0.05)
    writer.write(b"F\r")
    assert await reader.readuntil(b"\r") == b"R\r"
    writer.close()


@pytest.mark.slewline(on="tcp")
async def test_pyserial_asyncio_on_a_socket(gs_c200s):
    library = pytest.importorskip("serial_asyncio")
    reader, writer = await library.open_serial_connection(url=gs_c200s.url)
    writer.write(b"F\r")
    assert await reader.readuntil(b"\r") == b"R\r"
    writer.close()


async def test_pyserial_asyncio_on_a_url_is_refused_when_it_opens(gs_c200s):
    library = pytest.importorskip("serial_asyncio")
    with pytest.raises(serial.SerialException, match=r'on="tcp"'):
        await library.open_serial_connection(url=gs_c200s.url)
