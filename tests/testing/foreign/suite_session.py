"""Fixtures of a class, of a module of tests and of the session, which share a module."""

import pytest
import serial
from feeder import FORMAT, Feeder


@pytest.fixture(scope="session")
def plant(slewline_for_session):
    return slewline_for_session("gs-c200s", straps={"chs": 0})


@pytest.fixture(scope="module")
def rack(slewline_for_module):
    return [slewline_for_module("gs-c200s", straps={"chs": 0}) for _ in range(2)]


@pytest.fixture(scope="class")
def feeder(slewline_for_class):
    module = slewline_for_class("gs-c200s", straps={"chs": 0})
    with serial.serial_for_url(module.url, 9600, **FORMAT) as port:
        yield Feeder(port)


class TestInOrder:
    """Each test goes on where the one before has stopped."""

    def test_one(self, feeder):
        feeder.feed(10)
        feeder.wait()
        assert feeder.position == 10

    def test_two(self, feeder):
        feeder.feed(10)
        feeder.wait()
        assert feeder.position == 20


class TestAnew:
    def test_another_class_has_another_module(self, feeder):
        assert feeder.position == 0


@pytest.mark.parametrize("number", range(3))
def test_the_session_has_one_module(plant, number):
    assert plant.ask("F") == "R"
    assert plant.url == plant.url


def test_the_rack_stays_the_same(rack):
    assert [rack[0].ask(line) for line in ("Po", "A1", "Px")] == ["Y"] * 3
    assert rack[0].url != rack[1].url


def test_and_is_found_again(rack):
    assert rack[0].ask("Q") == "A1\rEND"
    assert rack[1].ask("Q") == "END"
