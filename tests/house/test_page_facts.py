"""The pages state every fact that they stated before they were rewritten, or the reason for its absence is listed."""

from __future__ import annotations

import pytest

from tests.house.page_facts import KINDS, collected, dropped, facts, kept, missing, today

pytestmark = pytest.mark.check

PAGE = """# Title

Run `bench.run()` for 1,000 steps at 2.5 ms, with `--rate`, or [read on](../reference/api.md#times).

```console
$ slewline run a.cy525 --vcd b.vcd
 12 ms of output
```

    slewline serve cy525 --tcp 127.0.0.1:4001     a socket
"""
STATED = [
    ("code", "--rate"),
    ("code", "bench.run()"),
    ("command", "slewline run a.cy525 --vcd b.vcd"),
    ("command", "slewline serve cy525 --tcp 127.0.0.1:4001"),
    ("figure", "1000 step"),
    ("figure", "2.5 ms"),
    ("link", "reference/api.md"),
    ("option", "--rate"),
    ("option", "--tcp"),
    ("option", "--vcd"),
]


def test_no_fact_is_lost_without_a_reason() -> None:
    lost = [(kind, fact) for kind, fact in missing(collected(today()), kept()) if fact not in dropped()]
    assert lost == [], "state it on a page, or list it with the reason in page_facts_dropped.toml"


def test_each_dropped_fact_was_stated_and_is_stated_no_more() -> None:
    lost = {fact for _, fact in missing(collected(today()), kept())}
    assert sorted(set(dropped()) - lost) == []
    assert all(reason.endswith(".") for reason in dropped().values())


def test_the_facts_of_a_page_are_found() -> None:
    assert sorted(set(facts(PAGE, "howto"))) == STATED


@pytest.mark.parametrize("kind", KINDS)
def test_a_fact_that_leaves_the_page_is_missing(kind: str) -> None:
    before = collected({"howto/page.md": PAGE})
    gone = next(fact for found, fact in STATED if found == kind)
    now = {each: before[each] - {gone} if each == kind else before[each] for each in KINDS}
    assert missing(now, before) == [(kind, gone)]


def test_the_list_has_all_kinds() -> None:
    assert {kind: len(found) > 100 for kind, found in kept().items()} == dict.fromkeys(KINDS, True)
