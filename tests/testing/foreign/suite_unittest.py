"""Without pytest: python -m unittest."""

import asyncio
import unittest

import serial
from feeder import FORMAT, Feeder

from slewline.testing import running


class FeederTest(unittest.TestCase):
    def setUp(self):
        self.module = self.enterContext(running("gs-c200s", straps={"chs": 0}))
        self.feeder = Feeder(self.enterContext(serial.serial_for_url(self.module.url, 9600, **FORMAT)))

    def test_a_sheet_is_fed(self):
        self.feeder.feed(120)
        self.feeder.wait()
        self.assertEqual(self.feeder.position, 120)
        self.module.assert_steps(120, direction=+1)

    def test_steps_that_are_asked_for_one_by_one(self):
        for steps in (1, -2, 3):
            with self.subTest(steps=steps):
                since = self.module.now
                self.feeder.feed(steps)
                self.feeder.wait()
                self.module.assert_steps(abs(steps), since=since)

    def test_the_module_goes_away(self):
        self.module.close()
        with self.assertRaises(serial.SerialException):
            self.feeder.ask("F")


class OneForAll(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.module = cls.enterClassContext(running("gs-c200s", straps={"chs": 0}))

    def test_first(self):
        self.assertEqual(self.module.ask("F"), "R")

    def test_second(self):
        self.assertEqual(self.module.ask("V1"), "V+0")


class InAsyncio(unittest.IsolatedAsyncioTestCase):
    async def test_a_socket(self):
        with running("gs-c200s", on="tcp", straps={"chs": 0}) as module:
            host, port = module.url.removeprefix("socket://").split(":")
            reader, writer = await asyncio.open_connection(host, int(port))
            writer.write(b"F\r")
            self.assertEqual(await reader.readuntil(b"\r"), b"R\r")
            writer.close()
            await writer.wait_closed()


if __name__ == "__main__":
    unittest.main()
