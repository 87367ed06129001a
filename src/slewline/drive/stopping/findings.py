"""Reports of a drive's problems, as findings of its chip, and corrections of the chip's position register."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ..drive_state import DriveState
    from ..feeder import Feeder


def signed(number: int) -> int:
    """Return a number, modulo 2^32, as a signed 32-bit number."""
    return (number + (1 << 31)) % (1 << 32) - (1 << 31)


class DriveFindings:
    """The reporter of a drive's problems; `reported` has the texts of all problems so far."""

    def __init__(self, state: DriveState, feeder: Feeder) -> None:
        self.state, self.feeder, self.reported = state, feeder, list[str]()

    def report(self, code: str, text: str, position: int | None = None) -> None:
        """Report a problem as a finding of the chip; if a position is given, set the position register to it."""
        self.reported.append(f"{code}: {text}")
        self.state.chip.motor_report(code, text, self.state.number, position)

    def uncertain(self, text: str) -> None:
        """Report that the position of the motor is no longer known."""
        self.state.trust(False)
        self.report("position-uncertain", text)

    def register(self, missing: int) -> int:
        """Return the position register as it would be without the `missing` steps.

        These are the net steps that the chip made and the motor did not.  If the register has not counted them,
        it is returned unchanged.
        """
        axis = self.state.axis
        counted = missing if axis.past[-1].counts or not axis.past[-1].playing else 0
        return axis.low + (axis.position - counted - axis.low) % axis.modulus

    def taken_over(self, missing: int) -> None:
        """Report that the motor did not make `missing` of the chip's net steps, and correct the chip's register.

        Do nothing if `missing` is 0.
        """
        if missing:
            register = self.register(missing)
            self.report(
                "position-taken-over",
                f"the motor is at {register}: {abs(missing)} steps of the model were not output; the position "
                f"register is set to {register}",
                register,
            )

    def take_over(self, position: int, known: bool = True) -> None:
        """Set the position register of the chip to the count of the board.

        Args:
            position: the count of the board.
            known: False if the chip has lost its registers; then only report that the position is uncertain.
        """
        missing = signed(self.state.axis.travel - position)
        self.feeder.counted()
        if known:
            self.taken_over(missing)
        else:
            self.uncertain("the chip was stopped by reset or supply, and its position is lost; home it")
