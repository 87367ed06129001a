"""A hook: who listens hears everything, whatever others do to the hook meanwhile."""

from __future__ import annotations

import pytest

from slewline.core.time.hook import Hook
from slewline.errors import UsageError


def test_listeners_are_called_in_the_order_in_which_they_were_added() -> None:
    hook, heard = Hook(), []
    for name in ("one", "two"):
        assert hook.add(lambda number, name=name: heard.append((name, number))) in hook.listeners
    hook(1)
    hook(number=2)
    assert heard == [("one", 1), ("two", 1), ("one", 2), ("two", 2)]


def test_a_hook_reports_whether_it_has_listeners() -> None:
    hook = Hook()
    assert not hook
    listener = hook.add(print)
    assert hook
    hook.remove(listener)
    assert not hook
    hook()  # nobody hears


def test_a_listener_removed_inside_a_call_is_not_called_any_more() -> None:
    hook, heard = Hook(), []

    def first() -> None:
        heard.append("first")
        if third in hook.listeners:
            hook.remove(third)

    def third() -> None:
        heard.append("third")

    hook.add(first)
    hook.add(lambda: heard.append("second"))
    hook.add(third)
    hook.add(lambda: heard.append("fourth"))
    hook()
    hook()
    assert heard == ["first", "second", "fourth"] * 2


def test_a_listener_that_removes_itself_silences_no_other() -> None:
    hook, heard = Hook(), []

    def once() -> None:
        heard.append("once")
        hook.remove(once)

    hook.add(once)
    hook.add(lambda: heard.append("always"))
    hook()
    hook()
    assert heard == ["once", "always", "always"]


def test_a_listener_added_inside_a_call_is_called_from_the_next_time() -> None:
    hook, heard = Hook(), []

    def late() -> None:
        heard.append("late")

    def first() -> None:
        heard.append("first")
        if late not in hook.listeners:
            hook.add(late)

    hook.add(first)
    hook()
    assert heard == ["first"]
    hook()
    assert heard == ["first", "first", "late"]


def test_one_that_was_added_twice_is_removed_once() -> None:
    hook, heard = Hook(), []
    for _ in range(2):
        hook.add(heard.append)
    hook.remove(heard.append)
    hook(7)
    assert heard == [7]


def test_only_listeners_can_be_removed() -> None:
    with pytest.raises(ValueError, match="it is not a listener"):
        Hook().remove(print)


def test_a_hook_is_a_listener_of_another_one() -> None:
    near, far, heard = Hook(), Hook(), []
    near.add(far)
    near(1)
    far.add(heard.append)
    near(2)
    assert heard == [2]


def test_only_a_function_listens():
    with pytest.raises(UsageError, match="a listener 'print'; expected a function"):
        Hook().add("print")
