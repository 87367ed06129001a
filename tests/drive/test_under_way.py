"""Events of a board in their order, whatever order they arrive in."""

from __future__ import annotations

from slewline.drive.board.in_flight import EventOrder
from slewline.drive.board.wire import BoardEvent


def event(number: int, tick: int = 0) -> BoardEvent:
    return BoardEvent(number % 256, 9, 0, 0, 0, 0, tick)


def taken(order: EventOrder) -> list[int]:
    out = []
    while (each := order.take()) is not None:
        out.append(each.number)
    return out


def test_an_early_one_waits_and_those_before_it_are_missing() -> None:
    order = EventOrder(254)
    assert order.complete and order.missing(set()) == []
    order.arrived(event(257))
    assert taken(order) == [] and not order.complete
    order.asked[255] = 77
    assert order.missing(set()) == [(254, 0), (255, 77), (0, 0)]
    assert order.missing({255, None}) == [(254, 0), (0, 0)]
    for number in (255, 256, 254):
        order.arrived(event(number))
    assert taken(order) == [254, 255, 0, 1] and order.complete and order.asked == {}


def test_one_that_came_before_is_not_kept_for_the_next_round_of_numbers() -> None:
    order = EventOrder(0)
    order.arrived(event(0, tick=1))
    assert taken(order) == [0]
    order.arrived(event(0, tick=1))  # once more
    for number in range(1, 256):
        order.arrived(event(number))
        assert taken(order) == [number]
    assert order.take() is None
    order.arrived(event(256, tick=2))
    assert order.take() == event(0, tick=2)


def test_records_that_the_board_has_forgotten_are_given_up() -> None:
    order = EventOrder(0)
    order.counted(8)
    assert order.lost == 0 and len(order.missing(set())) == 8
    order.counted(10)
    assert order.lost == 2 and order.missing(set())[0] == (2, 0)


def test_more_than_half_a_round_of_numbers_is_given_up_as_well() -> None:
    order = EventOrder(0)
    order.counted(200)
    assert order.lost == 192 and order.missing(set())[0] == (192, 0)
    order.arrived(event(193))  # a repeated one: those behind it remain known
    assert len(order.missing(set())) == 7


def test_an_early_one_is_taken_though_those_before_it_are_given_up() -> None:
    order = EventOrder(0)
    order.arrived(event(2))
    order.counted(13)
    assert taken(order) == [2] and order.lost == 2
    order.counted(13)
    assert order.lost == 4 and order.missing(set())[0] == (5, 0)
