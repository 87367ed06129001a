"""The state of a motor record, and the values of its fields; nothing here waits or accesses the module.

                MRES          DIR, OFF
    steps  <---------->  dial  <------>  user            RVAL RRBV   DVAL DRBV   VAL RBV

Limits are stored in dial coordinates, as DHLM and DLLM; OFF and DIR convert them to the user limits.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from ..core.time.timebase import PS_PER_S
from .field_table import MOVE, PAUSE, ROWS, STOP

if TYPE_CHECKING:
    from ..language.ramp_answers import Ramp

DIRECTION, DONE, PROBLEM, MOVING, LOST, HOMED = 1 << 0, 1 << 1, 1 << 9, 1 << 10, 1 << 12, 1 << 14  # bits of MSTA
MOTIONS = {"JOGF": 1, "JOGR": 2, "HOMF": 8, "HOMR": 16}  # of MIP, by the button
A_MOVE = 32  # of MIP
STEPS_A_REVOLUTION = 200
ROUNDING = 1e-6  # of a step: three steps of 0.1 are no more than 0.3


class RecordState:
    """The state of a record.

    Args:
        resolution: units per step.
        steps: the lowest and highest positions to which the part can move.
        position: the position of the motor, in steps.
        ramp: the ramp of the motor's moves.
        fastest: the highest rate of the part (steps/s).

    Attributes:
        kept: the values of the fields that a client can write, and that keep the value written last.
        val, dval: the target position, in user and dial coordinates.
        low, high: the limits, in dial coordinates.
        ramps: the ramps of moves, backlash moves, jogs and homing runs, as the part can make them.
        law: the rates and times of the ramps, as clients have written them; the part may only be able to
            make approximately these ramps.
    """

    def __init__(self, resolution: float, steps: tuple[int, int], position: int, ramp: Ramp, fastest: float) -> None:
        self.resolution, self.steps, self.position, self.fastest = resolution, steps, position, fastest
        self.kept: dict[str, Any] = {row.name: row.value for row in ROWS.values() if row.put}
        self.kept |= {"SPMG": 3, "NTM": 1, "TWV": abs(resolution), "RDBD": abs(resolution)}
        self.offset, self.sign = 0.0, 1
        self.low, self.high = sorted(step * resolution for step in steps)
        self.dval = self.dial_position
        self.val = self.user(self.dval)
        self.last = self.val, self.dval
        self.ramps = dict.fromkeys(("move", "backlash", "jog", "home"), ramp)
        scale, time_s = abs(resolution), ramp.time_ps / PS_PER_S
        rates = dict.fromkeys(("VELO", "BVEL", "JVEL"), ramp.top * scale) | {"HVEL": ramp.start * scale}
        self.law = rates | {"VBAS": ramp.start * scale, "ACCL": time_s, "BACC": time_s}
        self.law["JAR"] = acceleration(ramp) * scale
        self.button = ""  # the active button: one of MOTIONS
        self.forward = True  # in steps
        self.done, self.moving, self.violated = True, False, False
        self.missed = self.homed = self.lost = False
        self.updating, self.obeyed = 0, self.kept["SPMG"]  # STUP, LSPG
        self.texts: dict[str, str] = {}
        self.alarm = 0, 0  # STAT, SEVR

    # ----------------------------------------------------------------------------------------------------- coordinates
    def user(self, dial: float) -> float:
        """Return a dial position in user coordinates."""
        return dial * self.sign + self.offset

    def dial(self, user: float) -> float:
        """Return a user position in dial coordinates."""
        return (user - self.offset) * self.sign

    def raw(self, dial: float) -> int:
        """Return the step nearest to a dial position."""
        return round(dial / self.resolution)

    @property
    def dial_position(self) -> float:
        """The last position at rest, in dial coordinates."""
        return self.position * self.resolution

    @property
    def user_limits(self) -> tuple[float, float]:
        """The lowest and highest allowed positions, in user coordinates."""
        low, high = self.user(self.low), self.user(self.high)
        return (low, high) if self.sign > 0 else (high, low)

    @property
    def unlimited(self) -> bool:
        """True if the limits are off, which means that both are 0."""
        return self.low == 0 == self.high

    def beyond(self, dial: float) -> bool:
        """Return whether a dial position is beyond the limits, or out of the part's reach."""
        least, most = self.steps
        slack = abs(self.resolution) * ROUNDING
        soft = not self.unlimited and not self.low - slack <= dial <= self.high + slack
        return soft or not least <= self.raw(dial) <= most

    def violates(self, dial: float) -> bool:
        """Return whether a move to a dial position is refused; a move back towards an exceeded limit is allowed.

        If there is a backlash distance, the start of the second move is checked, too.
        """
        least, most = self.steps
        ends = [leg for leg, _ in self.legs(dial)]
        if any(not least <= self.raw(end) <= most for end in ends):
            return True
        back = (self.low <= self.high) and (self.high < dial < self.dval or self.low > dial > self.dval)
        return not back and any(self.beyond(end) for end in ends)

    def legs(self, dial: float) -> list[tuple[float, Ramp]]:
        """Return the moves that lead to a dial position, each with its ramp; there are two if backlash is taken up."""
        backlash = self.kept["BDST"]
        preferred = (dial > self.dial_position) == (backlash > 0)
        same = self.law["BVEL"] == self.law["VELO"] and self.law["BACC"] == self.law["ACCL"]
        if abs(backlash) < abs(self.resolution) or (preferred and same):
            return [(dial, self.ramps["move"])]
        last = (dial, self.ramps["backlash"])
        if preferred and abs(dial - self.dial_position) <= abs(backlash) + abs(self.resolution):
            return [last]
        return [(dial - backlash, self.ramps["move"]), last]

    # --------------------------------------------------------------------------------------------------------- switches
    @property
    def setting(self) -> bool:
        """True if puts define the present position instead of moving the motor."""
        return bool(self.kept["SET"]) and not self.kept["IGSET"]

    @property
    def paused(self) -> bool:
        """True if no motion may begin: SPMG is Stop or Pause."""
        return self.kept["SPMG"] in (STOP, PAUSE)

    @property
    def once(self) -> bool:
        """True if only one more motion may begin: SPMG is Move."""
        return bool(self.kept["SPMG"] == MOVE)

    def settle(self) -> None:
        """Set the target position to the present position."""
        self.dval = self.dial_position
        self.val = self.user(self.dval)
        self.last = self.val, self.dval

    # ----------------------------------------------------------------------------------------------------------- fields
    def values(self) -> Mapping[str, Any]:
        """Return the values of all variable fields in the order in which they are posted, with DMOV last."""
        return {**self.kept, **self._coordinates(), **self._rates(), **self._motion()}

    def _coordinates(self) -> Mapping[str, Any]:
        low, high = self.user_limits
        raw_low, raw_high = sorted((self.low / self.resolution, self.high / self.resolution))
        fixed = {"MRES": self.resolution, "ERES": self.resolution, "UREV": self.resolution * STEPS_A_REVOLUTION}
        return fixed | {
            "OFF": self.offset,
            "DIR": int(self.sign < 0),
            "_able": self.kept["DISP"],
            **{"HLM": high, "LLM": low, "DHLM": self.high, "DLLM": self.low, "RHLM": raw_high, "RLLM": raw_low},
            **{"VAL": self.val, "DVAL": self.dval, "RVAL": self.raw(self.dval)},
            **{"LVAL": self.last[0], "LDVL": self.last[1], "LRVL": self.raw(self.last[1])},
        }

    def _rates(self) -> Mapping[str, float]:
        scale = abs(self.resolution)
        a_revolution = scale * STEPS_A_REVOLUTION
        move, backlash, jog = (self.ramps[key] for key in ("move", "backlash", "jog"))
        rates = {"VELO": move.top, "BVEL": backlash.top, "JVEL": jog.top, "HVEL": self.ramps["home"].start}
        speeds = {"S": move.top, "SBAK": backlash.top, "SBAS": move.start, "SMAX": self.fastest}
        return {
            **{key: rate * scale for key, rate in rates.items()},
            **{key: rate * scale / a_revolution for key, rate in speeds.items()},
            **{"VBAS": move.start * scale, "VMAX": self.fastest * scale},
            **{"ACCL": move.time_ps / PS_PER_S, "BACC": backlash.time_ps / PS_PER_S},
            **{"ACCS": acceleration(move) * scale, "JAR": acceleration(jog) * scale},
        }

    def _motion(self) -> Mapping[str, Any]:
        buttons = dict.fromkeys(MOTIONS, 0) | ({self.button: 1} if self.button else {})
        status = DIRECTION * self.forward | DONE * self.done | MOVING * self.moving | HOMED * self.homed
        status |= (PROBLEM | LOST) * self.lost
        doing = MOTIONS.get(self.button, A_MOVE) if self.moving else 0
        return {
            **self.texts,
            **buttons,
            **{"LSPG": self.obeyed, "STUP": self.updating, "LVIO": int(self.violated), "MISS": int(self.missed)},
            **{"TDIR": int(self.forward), "CDIR": int(self.forward), "MIP": doing},
            **{"STAT": self.alarm[0], "SEVR": self.alarm[1]},
            **{"RBV": self.user(self.dial_position), "DRBV": self.dial_position},
            **{"RRBV": self.position, "RMP": self.position},
            **{"DIFF": self.dval - self.dial_position, "RDIF": self.raw(self.dval) - self.position},
            **{"MSTA": float(status), "MOVN": int(self.moving), "DMOV": int(self.done)},
        }


def acceleration(ramp: Ramp) -> float:
    """Return the increase in rate over a ramp, divided by the ramp time (steps/s^2); 0 if the ramp time is 0."""
    return (ramp.top - ramp.start) * PS_PER_S / ramp.time_ps if ramp.time_ps else 0.0


def digits(resolution: float) -> int:
    """Return the number of decimals with which positions of this resolution are shown."""
    return max(0, -math.floor(math.log10(abs(resolution))))
