"""What is to be tuned, and what was found: values that can be pickled, and written as JSON."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from typing import Any

from ..core.time.timebase import readable
from ..errors import UsageError
from ..language.ramps import Value
from ..parts.motors.data import DriverData, LoadData, MotorData
from ..parts.motors.law import CHOPPED_PS, STEP_PS
from .grid import Grid
from .perturbations import Perturbation, Scenario, System, scenarios


@dataclass(frozen=True)
class TuningTask:
    """A chip and its grid, a motor with driver and load, and what may be otherwise."""

    part: str
    crystal_hz: int
    options: Mapping[str, Any]
    steps: int
    stepping: str
    motor: MotorData
    driver: DriverData
    load: LoadData
    grid: Grid
    perturbations: tuple[Perturbation, ...]
    step_ps: int = STEP_PS
    said: Mapping[str, Any] = field(default_factory=dict, compare=False)  # motor, driver and load as a user gave them

    @property
    def system(self) -> System:
        """Motor, driver and load."""
        return self.motor, self.driver, self.load

    def scenarios(self) -> tuple[Scenario, ...]:
        """Return all ways in which a candidate is judged."""
        return scenarios(self.system, self.perturbations, self.stepping, self.step_ps)

    def switching(self) -> tuple[Scenario, ...]:
        """Return the same ways with a switching chopper, if the driver is the mean of one."""
        if self.driver.kind != "averaged":
            return ()
        system = self.motor, replace(self.driver, kind="chopper"), self.load
        return scenarios(system, self.perturbations, self.stepping, CHOPPED_PS, ", switching")

    def as_json(self) -> dict[str, Any]:
        """Return all that verdicts depend on."""
        found = asdict(replace(self, said={}))
        del found["said"]
        found["grid"] = {name: list(of) for name, of in zip(self.grid.names, self.grid.values, strict=True)}
        found["perturbations"] = {row.name: dict(row.changes) for row in self.perturbations}
        return found


@dataclass(frozen=True)
class Chosen:
    """A move that holds.

    Attributes:
        values: its parameters, by name.
        time_ps: how long it takes, ps.
        worst: its greatest lag under any scenario, in full steps.
    """

    values: Mapping[str, Value]
    time_ps: int
    worst: float

    def __str__(self) -> str:
        values = " ".join(f"{name}={value}" for name, value in self.values.items())
        return f"{values}: {readable(self.time_ps)}, worst lag {self.worst:.2f} steps"


@dataclass(frozen=True)
class MapPlace:
    """A place of the map.

    Attributes:
        values: the parameters there, by name.
        time_ps: how long the move takes, ps; None: the part refuses it.
        says: "holds", "fails", "fails nominally" or "refused".
        killer: the scenario that kills the move; None: nothing does, or the part refuses it.
        worst: the greatest lag, in full steps.
    """

    values: Mapping[str, Value]
    time_ps: int | None
    says: str
    killer: str | None
    worst: float | None


class NothingHolds(UsageError):
    """Every candidate loses steps."""


@dataclass(frozen=True, repr=False)
class Tuned:
    """What a search has found.

    Attributes:
        task: what was looked for, with motor, driver and load.
        candidates: how many the grid has.
        refused: how many of them the part refuses.
        best: the fastest move that holds; None: none does.
        recommended: the fastest one with some distance to those that fail; None: there is none.
        switched: the recommended move was judged with the switching chopper, too.
        runs: how many runs the result depends on.
        runs_here: how many of them were computed in this session.
        exhaustive: how many a map without any stop would take.
        killers: how many candidates failed, by the scenario that they failed in.
        map: every candidate, if all were judged.
    """

    task: TuningTask
    candidates: int
    refused: int
    best: Chosen | None
    recommended: Chosen | None
    switched: bool
    runs: int
    runs_here: int
    exhaustive: int
    killers: Mapping[str, int]
    map: tuple[MapPlace, ...] = ()

    def __repr__(self) -> str:
        task = self.task
        return (
            f"<Tuned {task.part}, {task.motor.name}: {task.steps} steps; best {self.best}; "
            f"recommended {self.recommended}; {self.runs} of {self.exhaustive} runs>"
        )

    @property
    def chosen(self) -> Chosen:
        """The recommended move, or the best one where none is recommended.

        Raises:
            NothingHolds: there is none.
        """
        chosen = self.recommended or self.best
        if chosen is None:
            raise NothingHolds("no move of the grid holds; see `killers`")
        return chosen

    def as_json(self) -> dict[str, Any]:
        """Return everything as data for JSON."""
        found: dict[str, Any] = {
            name: value for name, value in vars(self).items() if name not in ("task", "best", "recommended", "map")
        }
        found["killers"] = dict(self.killers)
        for name in ("best", "recommended"):
            chosen = getattr(self, name)
            found[name] = chosen and {**asdict(chosen), "values": dict(chosen.values)}
        if self.map:
            found["map"] = [asdict(place) for place in self.map]
        return {"task": self.task.as_json(), **found}
