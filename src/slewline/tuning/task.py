"""A tuning task, and its result: values that can be pickled and written as JSON."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from typing import Any

from ..core.time.timebase import readable
from ..errors import UsageError
from ..language.ramp_answers import Value
from ..parts.motors.choppers import chopper_notes
from ..parts.motors.law import CHOPPED_PS, STEP_PS
from ..parts.motors.motor_data import DriverData, LoadData, MotorData
from ..parts.motors.motors import assumptions
from .grid import Grid
from .perturbations import Perturbation, Scenario, System, scenarios


@dataclass(frozen=True)
class TuningTask:
    """A chip and its grid, a motor with driver and load, and the perturbations."""

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
    given: Mapping[str, Any] = field(default_factory=dict, compare=False)  # motor, driver and load as given by the user

    @property
    def system(self) -> System:
        """The motor, driver and load."""
        return self.motor, self.driver, self.load

    def scenarios(self) -> tuple[Scenario, ...]:
        """Return all scenarios under which a candidate is judged."""
        return scenarios(self.system, self.perturbations, self.stepping, self.step_ps)

    def switching(self) -> tuple[Scenario, ...]:
        """Return the scenarios with a switching chopper, if the driver is an averaged chopper; otherwise empty."""
        if self.driver.kind != "averaged":
            return ()
        system = self.motor, replace(self.driver, kind="chopper"), self.load
        return scenarios(system, self.perturbations, self.stepping, CHOPPED_PS, ", switching")

    def as_json(self) -> dict[str, Any]:
        """Return all data on which verdicts depend."""
        found = asdict(replace(self, given={}))
        del found["given"]
        found["grid"] = {name: list(of) for name, of in zip(self.grid.names, self.grid.values, strict=True)}
        found["perturbations"] = {row.name: dict(row.changes) for row in self.perturbations}
        return found


@dataclass(frozen=True)
class Chosen:
    """A move that loses no steps.

    Attributes:
        values: the move's parameters, by name.
        time_ps: the duration of the move, ps.
        worst: the maximum lag under all perturbations, in full steps.
    """

    values: Mapping[str, Value]
    time_ps: int
    worst: float

    def __str__(self) -> str:
        values = " ".join(f"{name}={value}" for name, value in self.values.items())
        return f"{values}: {readable(self.time_ps)}, worst lag {self.worst:.2f} steps"


@dataclass(frozen=True)
class MapPlace:
    """A candidate on the map of the grid.

    Attributes:
        values: the move's parameters, by name.
        time_ps: the duration of the move, ps; None if the part refuses the move.
        says: the verdict: "holds", "fails", "fails nominally" (without any perturbation) or "refused".
        killer: the name of the scenario in which the move fails; None if it holds or if the part refuses it.
        worst: the maximum lag, in full steps; None if the part refuses the move.
    """

    values: Mapping[str, Value]
    time_ps: int | None
    says: str
    killer: str | None
    worst: float | None


class NothingHolds(UsageError):
    """The error raised if every candidate in the grid loses steps, so that none can be recommended."""


@dataclass(frozen=True, repr=False)
class Tuned:
    """The result of `slewline.tune`.

    Attributes:
        task: the task, with motor, driver and load.
        candidates: the number of grid points whose moves the part accepts.
        refused: the number of grid points whose moves the part refuses.
        best: the fastest move that holds, that is, loses no steps in any scenario; None if none does.
        recommended: the fastest move with a margin to all failing moves; None if there is none.
        switched: True if the recommended move was judged with the switching chopper as well.
        runs: the number of runs on which the result is based.
        runs_here: the number of runs that were computed in this session.
        exhaustive: the number of runs that judging all candidates in all scenarios would take.
        killers: the number of candidates that failed in each scenario, by the scenario's name.
        map: every grid point, if all candidates were judged; otherwise empty.
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
    def assumed(self) -> tuple[str, ...]:
        """The assumptions made for omitted motor figures, as texts; empty for a motor given by name."""
        return assumptions(self.task.given.get("motor"))

    @property
    def notes(self) -> tuple[str, ...]:
        """Texts on effects, other than the ramps, that may decide the result, such as a large chopper ripple."""
        return chopper_notes(self.task.motor, self.task.driver, self.task.given.get("driver"))

    @property
    def chosen(self) -> Chosen:
        """The recommended move or, if none is recommended, the fastest one that holds.

        Raises:
            NothingHolds: no move holds.
        """
        chosen = self.recommended or self.best
        if chosen is None:
            raise NothingHolds("no move of the grid passes all scenarios; see `killers`")
        return chosen

    def as_json(self) -> dict[str, Any]:
        """Return the whole result as data for JSON."""
        found: dict[str, Any] = {
            name: value for name, value in vars(self).items() if name not in ("task", "best", "recommended", "map")
        }
        found["killers"] = dict(self.killers)
        for name in ("best", "recommended"):
            chosen = getattr(self, name)
            found[name] = chosen and {**asdict(chosen), "values": dict(chosen.values)}
        if self.map:
            found["map"] = [asdict(place) for place in self.map]
        return {"task": self.task.as_json(), "assumed": list(self.assumed), "notes": list(self.notes), **found}
