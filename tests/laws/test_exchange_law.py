"""The exchange law: what goes between two ends as a value is what goes edge by edge, whoever disturbs it and when.

The twin does the same, and its exchanges never begin.  Wires are recorded from the beginning, later, or never.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from random import Random
from types import ModuleType

import pytest

from tests.ensembles import few

from . import exchange_cy545, exchange_flow, exchange_handshakes, exchange_mc, exchange_motions
from .exchanges import MS, Act, Dialogue, World, differences, played

FAMILIES: dict[str, tuple[ModuleType, type[World]]] = {
    "cy545": (exchange_cy545, exchange_cy545.Remembering),
    "flow": (exchange_flow, exchange_flow.Offered),
    "handshakes": (exchange_handshakes, exchange_handshakes.Strobed),
    "mc1451a": (exchange_mc, exchange_mc.Spoken),
    "motions": (exchange_motions, exchange_motions.Moving),
}
BY_VALUE = {"flow": 60, "handshakes": 60}  # instants, in some quiet dialogues: a whole command has one
TOLD = {  # seeds of base dialogues, each of which has shown a fault that is mended
    "cy545": (11444,),
    "flow": (0, 2, 4, 7, 13, 14, 17, 18, 28, 97, 98, 157, 174, 195, 1042, 1065, 1071, 1122, 1258, 1383, 1477),
    "handshakes": (5, 9, 13, 36, 62, 79, 95, 119, 1034, 1071, 1275, 2349, 2511),
    "motions": (2, 13, 19, 822, 1185, 1187, 1250),
}
VARIANTS = 5  # of one dialogue: its quiet run, which shows where the edges are, is needed once
WANTED = {"record": 200, "drive": 200, "pulse": 100, "look": 300, "level": 40, "edges": 40, "gate": 50, "function": 20}
WANTED_OF = {"motions": {"function": 10, "wait": 200}}  # half of what is drawn there is a task that waits


def agree(family: str, seeds: range, variants: int = VARIANTS) -> Counter[str]:
    """Compare dialogues with their twins; return how often something disturbed them."""
    module, make = FAMILIES[family]
    counted: Counter[str] = Counter()
    for seed in seeds:
        for dialogue in module.dialogues(seed, variants):
            counted.update(act.what for act in dialogue.acts)
            compare(make, dialogue)
    return counted


def compare(make: Callable[[Dialogue, int | None], World], dialogue: Dialogue) -> None:
    """Play a dialogue by value, and as one of its twins, the tasks of a round in another order."""
    twin = played(make, dialogue, "recorded" if dialogue.seed % 4 else "played", dialogue.seed)
    found = differences(played(make, dialogue, "kept" if dialogue.seed % 2 else "", dialogue.seed), twin)
    assert not found, f"{found[:3]}\n  {dialogue}"


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("block", few(range(10), 1))
def test_an_exchange_that_is_disturbed_leaves_what_its_twin_leaves(family: str, block: int) -> None:
    agree(family, range(block * 10, block * 10 + 3))


@pytest.mark.parametrize("family", TOLD)
def test_dialogues_that_once_parted_from_their_twins_agree(family: str) -> None:
    module, make = FAMILIES[family]
    for seed in TOLD[family]:
        for dialogue in module.dialogues(seed, VARIANTS):
            compare(make, dialogue)


@pytest.mark.parametrize("family", BY_VALUE)
def test_recorded_commands_of_any_instant_have_the_edges_of_the_twin_in_any_window(family: str) -> None:
    """With pauses between them, begun between two ticks of the chip's clock."""
    module, make = FAMILIES[family]
    for seed in range(12):
        quiet, rnd = module.base(seed), Random(seed)
        acts = [Act(rnd.randrange(30 * MS), "send", (rnd.choice(("N 5\r", "R 7\rN 8\r")),)) for _ in range(6)]
        dialogue = replace(quiet, until_ps=40 * MS, acts=sorted(acts))
        fast, twin = (played(make, dialogue, how, seed) for how in ("kept", "recorded"))
        assert not differences(fast, twin)
        for name in fast.wires:
            for _ in range(5):
                start, stop = sorted((rnd.randrange(41 * MS), rnd.randrange(41 * MS)))
                one, two = (world.bench.edges(name, start, stop) for world in (fast, twin))
                assert [*map(list, one)] == [*map(list, two)]


@pytest.mark.long
@pytest.mark.timeout(3000)
@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("block", range(10))
def test_ten_thousand_dialogues_agree(family: str, block: int) -> None:
    counted = agree(family, range(10_000 + block * 200, 10_200 + block * 200))
    assert all(counted[what] >= wanted for what, wanted in (WANTED | WANTED_OF.get(family, {})).items()), counted


@pytest.mark.parametrize("twin", ["", "kept", "played", "recorded"])
@pytest.mark.parametrize("family", FAMILIES)
def test_a_quiet_dialogue_goes_by_value_and_none_of_its_twin(family: str, twin: str) -> None:
    """Else the law would say nothing."""
    module, make = FAMILIES[family]
    by_value: Counter[bool] = Counter()  # instants

    class Counting(make):  # type: ignore[misc, valid-type]
        def hear(self) -> None:
            super().hear()
            self.bench.on_commit.add(self.count)

        def count(self, _ps: int) -> None:
            # Handshakes: by their own line; the bus of a CY545 is also that of its memory, which has exchanges as well.
            wires = ["x.io_request"] if family in BY_VALUE else self.pins
            by_value[any(self.pins[name].net.exchange is not None for name in wires)] += 1

    for seed in range(12):
        played(Counting, module.base(seed), twin)
    assert sum(by_value.values()) > 400
    assert by_value[True] == 0 if twin in ("played", "recorded") else by_value[True] > BY_VALUE.get(family, 300)
