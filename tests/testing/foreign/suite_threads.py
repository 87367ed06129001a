"""A program with a thread that reads; some tests leave it running, and the port open."""

import threading
import time

import pytest
import serial
from feeder import FORMAT, Feeder

pytestmark = pytest.mark.slewline(straps={"chs": 0})


class Reader(threading.Thread):
    """Gathers lines until its port is closed, or has gone."""

    def __init__(self, port):
        super().__init__(daemon=True)
        self.port, self.lines, self.error = port, [], None
        self.came = threading.Condition()

    def run(self):
        line = b""
        try:
            while self.port.is_open:
                line += self.port.read(1)
                if line.endswith(b"\r"):
                    with self.came:
                        self.lines.append(line)
                        self.came.notify_all()
                    line = b""
        except serial.SerialException as error:
            self.error = error

    def wait(self, number):
        with self.came:
            assert self.came.wait_for(lambda: len(self.lines) >= number, 60)


@pytest.mark.slewline(rate=1)
def test_one_thread_reads_and_another_writes(gs_c200s):
    port = serial.serial_for_url(gs_c200s.url, 9600, **FORMAT)
    reader = Reader(port)
    reader.start()
    for _ in range(3):
        port.write(b"F\r")
    reader.wait(3)
    assert reader.lines == [b"R\r"] * 3
    port.close()
    reader.join(60)
    assert not reader.is_alive()


@pytest.mark.slewline(rate=1)
def test_a_reader_that_is_left_behind(gs_c200s):
    Reader(serial.serial_for_url(gs_c200s.url, 9600, **FORMAT)).start()


@pytest.mark.slewline(rate=1)
def test_a_reader_learns_that_the_adapter_is_gone(gs_c200s):
    reader = Reader(serial.serial_for_url(gs_c200s.url, 9600, **FORMAT))
    reader.start()
    with gs_c200s.faults.unplugged():
        reader.join(60)
    assert isinstance(reader.error, serial.SerialException)


def test_four_threads_with_a_module_each(slewline_module):
    def feed(module, found):
        with serial.serial_for_url(module.url, 9600, **FORMAT) as port:
            feeder = Feeder(port)
            feeder.feed(50)
            feeder.wait()
            found.append(feeder.position)

    found, modules = [], [slewline_module("gs-c200s") for _ in range(4)]
    threads = [threading.Thread(target=feed, args=(module, found)) for module in modules]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(60)
    assert found == [50] * 4


@pytest.mark.slewline(on="tcp")
def test_a_port_of_the_machine_that_is_left_open(gs_c200s):
    port = serial.serial_for_url(gs_c200s.url, timeout=60)
    port.write(b"F\r")
    assert port.read(2) == b"R\r"
    time.sleep(0.01)
