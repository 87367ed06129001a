"""Texts about commands that other parts may lack: why no replacement is needed, or advice to the user."""

from __future__ import annotations

# by role
NEEDLESS = {"clear_events": "no other part has these events", "axis": "each move names its axis"}  # by role
NEEDLESS_FORMS = {
    **dict.fromkeys(("SET_INTRPT_MASK", "RST_INTRPT"), NEEDLESS["clear_events"]),
    **dict.fromkeys(("SET_OUTPUT_HIGH", "SET_OUTPUT_STNDRD"), "other parts have one range of pulse rates"),
}

ALIKE = "use SET_PRFL_TRAP with SET_ACC in the source, prove that, and translate it: such a ramp has a counterpart"
TOGETHER = "here one axis moves after the other; let a host start separate parts at the same time"
REMEDIES = {  # by the form of the command
    "MULTI_UPDATE": TOGETHER,
    "SET_PRFL_S_CRV": ALIKE,
    "SET_PRFL_VEL": "move to positions with SET_PRFL_TRAP, if the motion has an end",
    "MTR_OFF": "let the host switch the driver off",
    "SET_PRFL_GEAR": "gear the axes by hand, or by a controller that follows an encoder",
}
AT_THE_UPDATE = "the update after it stops the motion"
ELSEWHERE = "runs a program that this text does not enter"
ADD_IT = "add the lines that enter the program, before this one"
BRANCHED = "starts the stored program by a loop or branch"
IN_PROGRAM = "put the loop or branch into the program, and run that"
SWITCHED = "takes its number from switches"
WRITE_IT = "write the number, and change the text when the switches change"
OVERFLOW = "moves through the overflow of the position register"
SET_DIRECTION = "set the direction of the target before the motion"
STOPS_IT = "stops a motion while it runs"
WHILE_IT_RUNS = "write a move of known length, or let a host stop the motion"
BY_HAND = "wire that signal at the target, or operate it by hand"
NO_AXIS = "acts on an axis that the text does not show"
SELECT_IT = "select the axis by its number"
AT_THE_START = "a program begins at its first line"
