"""The fields of a motor record: name, type, access, meaning.

The record, its documentation page and the tests read only this table.  A row with a `put` can be written
by clients: the `Effects` method of that name handles the put, and refuses a value that would have no
effect.  A row without a `put` is read-only, unless it is `fixed`: then clients may put its present
value, as programs that restore a whole list of fields do, and any other value is refused.
"""

from __future__ import annotations

from typing import Any, NamedTuple

RESTORE = ("Never", "Always", "NearZero", "Conditional")
UPDATE = ("OFF", "ON", "BUSY")
RETRY = ("Default", "Arithmetic", "Geometric", "In-Position")
NO_YES = ("NO", "YES")
SEVERITY = ("NO_ALARM", "MINOR", "MAJOR", "INVALID")
STATUS = (
    *("NO_ALARM", "READ", "WRITE", "HIHI", "HIGH", "LOLO", "LOW", "STATE"),
    *("COS", "COMM", "TIMEOUT", "HWLIMIT", "CALC", "SCAN", "LINK", "SOFT"),
)
STOP, PAUSE, MOVE, GO = range(4)  # of SPMG
SWITCH = ("Stop", "Pause", "Move", "Go")

LIMITED = {  # fields whose control limits are other fields: lower, upper
    "VAL": ("LLM", "HLM"),
    "RBV": ("LLM", "HLM"),
    "DVAL": ("DLLM", "DHLM"),
    "DRBV": ("DLLM", "DHLM"),
    "RVAL": ("RLLM", "RHLM"),
    "RRBV": ("RLLM", "RHLM"),
    "VELO": ("VBAS", "VMAX"),
}


class FieldRow(NamedTuple):
    """A field of the record.

    Attributes:
        name: the name of the field; a field whose name begins with "_" is a separate record, in addition to
            the motor record.
        kind: the type of the value, as in Channel Access: double, float, long, short, string or enum.
        description: the meaning of the field and of a put, for the documentation page.
        put: the method of `Effects` that handles a put; "" for none.
        fixed: True if the field has a single value, which is the only value that clients may put.
        value: the initial value; not used if the state computes the field.
        words: the words of an enum.
        unit: the unit, in which {} stands for the motor's unit.
    """

    name: str
    kind: str
    description: str
    put: str = ""
    fixed: bool = False
    value: Any = 0
    words: tuple[str, ...] = ()
    unit: str = "{}"

    @property
    def access(self) -> str:
        """The access that clients have: read, put, or put of the present value only."""
        return "put" if self.put else "fixed" if self.fixed else "read"


def _read(name: str, kind: str, description: str, **more: Any) -> FieldRow:
    return FieldRow(name, kind, description, **more)


def _put(name: str, kind: str, put: str, description: str, **more: Any) -> FieldRow:
    return FieldRow(name, kind, description, put, **more)


def _fixed(name: str, kind: str, value: Any, description: str, **more: Any) -> FieldRow:
    return FieldRow(name, kind, description, fixed=True, value=value, **more)


RATE, SPEED, TIME, ACCELERATION, NONE = "{}/sec", "rev/sec", "sec", "{}/s/s", ""
_LINK = "no link to another record"
_NO_SWITCH = "the module does not report its limit switches"
_NO_ENCODER = "the module has no encoder"
_UNUSED = "not used by the motor record either"
_OPEN_LOOP = "the module counts its own steps: there are no retries"

FIELDS: tuple[FieldRow, ...] = (
    # target positions
    _put("VAL", "double", "drive", "target position, user coordinates; moves the motor"),
    _put("DVAL", "double", "drive", "target position, dial coordinates; moves the motor"),
    _put("RVAL", "long", "drive", "target position in steps; moves the motor"),
    _put("RLV", "double", "drive", "moves by a distance, then returns to 0"),
    _put("TWF", "short", "drive", "1 moves forward by TWV, then returns to 0"),
    _put("TWR", "short", "drive", "1 moves back by TWV, then returns to 0"),
    _put("TWV", "double", "number", "distance of TWF and TWR"),
    _put("SYNC", "short", "sync", "1 sets VAL, DVAL and RVAL to the present position, then returns to 0; at rest"),
    # present positions
    _read("RBV", "double", "last position at rest, user coordinates"),
    _read("DRBV", "double", "last position at rest, dial coordinates"),
    _read("RRBV", "long", "last position at rest, in steps"),
    _read("RMP", "long", "the same as RRBV"),
    _read("REP", "long", f"0: {_NO_ENCODER}"),
    _read("DIFF", "double", "DVAL - DRBV"),
    _read("RDIF", "long", "RVAL - RRBV"),
    _read("LVAL", "double", "VAL of the last move"),
    _read("LDVL", "double", "DVAL of the last move"),
    _read("LRVL", "long", "RVAL of the last move"),
    _read("LRLV", "double", "0, like RLV"),
    # coordinates
    _put("OFF", "double", "offset", "VAL = DVAL * DIR + OFF; a put changes VAL, RBV, HLM and LLM, without motion"),
    _put("DIR", "enum", "direction", "direction of user coordinates; a put causes no motion", words=("Pos", "Neg")),
    _put("FOFF", "enum", "switch", "Frozen: SET and DIR do not change OFF", words=("Variable", "Frozen")),
    _put("FOF", "short", "preset_switch", "any put sets FOFF to Frozen"),
    _put("VOF", "short", "preset_switch", "any put sets FOFF to Variable"),
    _put("SET", "enum", "switch", "Set: puts define the position instead of moving the motor", words=("Use", "Set")),
    _put("SSET", "short", "preset_switch", "any put sets SET to Set"),
    _put("SUSE", "short", "preset_switch", "any put sets SET to Use"),
    _put("IGSET", "short", "number", "1: SET has no effect"),
    # resolution
    _fixed("MRES", "double", 1.0, "units per step: `--resolution`"),
    _fixed("SREV", "long", 200, "steps per revolution", unit="steps/rev"),
    _fixed("UREV", "double", 200.0, "MRES * SREV", unit="{}/rev"),
    _fixed("ERES", "double", 1.0, f"MRES: {_NO_ENCODER}"),
    _fixed("RRES", "double", 0.0, _LINK),
    _fixed("UEIP", "enum", 0, f"No: {_NO_ENCODER}", words=("No", "Yes")),
    _fixed("URIP", "enum", 0, f"No: {_LINK}", words=("No", "Yes")),
    _fixed("RSTM", "enum", 0, "Never: the position is that of the module", words=RESTORE),
    # rates
    _put("VELO", "double", "rate", "highest rate of moves, to the nearest that the part has", unit=RATE),
    _put("VBAS", "double", "rate", "first rate of every ramp, to the nearest that the part has", unit=RATE),
    _fixed("VMAX", "double", 0.0, "highest rate of the part", unit=RATE),
    _put("S", "double", "rate", "VELO in revolutions", unit=SPEED),
    _put("SBAS", "double", "rate", "VBAS in revolutions", unit=SPEED),
    _fixed("SMAX", "double", 0.0, "VMAX in revolutions", unit=SPEED),
    _put("ACCL", "double", "rate", "time from VBAS to VELO, to the nearest that the part has", unit=TIME),
    _put("ACCS", "double", "rate", "(VELO - VBAS) / ACCL", unit=ACCELERATION),
    _put("ACCU", "enum", "switch", "which of ACCL and ACCS a new VELO or VBAS keeps", words=("Use ACCL", "Use ACCS")),
    _put("BDST", "double", "number", "moves end in its direction: first to DVAL - BDST, then to DVAL; 0: one move"),
    _put("BVEL", "double", "rate", "highest rate of the second move for BDST", unit=RATE),
    _put("SBAK", "double", "rate", "BVEL in revolutions", unit=SPEED),
    _put("BACC", "double", "rate", "time from VBAS to BVEL", unit=TIME),
    _put("JVEL", "double", "rate", "highest rate of JOGF and JOGR; at rest", unit=RATE),
    _put("JAR", "double", "rate", "acceleration from VBAS to JVEL", unit=ACCELERATION),
    _put("HVEL", "double", "rate", "rate of HOMF and HOMR: the first rate of their ramp", unit=RATE),
    _fixed("FRAC", "float", 1.0, "a move covers the whole distance"),
    # limits
    _put("HLM", "double", "limit", "highest VAL; DHLM or DLLM follows"),
    _put("LLM", "double", "limit", "lowest VAL; DLLM or DHLM follows"),
    _put("DHLM", "double", "limit", "highest DVAL; if both are 0, only the limits of the part apply"),
    _put("DLLM", "double", "limit", "lowest DVAL"),
    _read("RHLM", "double", "highest RVAL"),
    _read("RLLM", "double", "lowest RVAL"),
    _read(
        "LVIO",
        "short",
        "1: VAL is beyond the limits, or was refused because of them; a motion beyond them is stopped",
    ),
    _read("HLS", "short", f"0: {_NO_SWITCH}"),
    _read("LLS", "short", f"0: {_NO_SWITCH}"),
    _read("RHLS", "short", f"0: {_NO_SWITCH}"),
    _read("RLLS", "short", f"0: {_NO_SWITCH}"),
    _fixed("HOPR", "double", 0.0, _UNUSED),
    _fixed("LOPR", "double", 0.0, _UNUSED),
    # buttons
    _put("SPMG", "enum", "mode", "Stop: as STOP; Pause: stops until Go; Move: one motion, then Pause", words=SWITCH),
    _read("LSPG", "enum", "SPMG in effect", value=GO, words=SWITCH),
    _put("STOP", "short", "stop", "1 stops along the ramp and sets VAL to RBV, then returns to 0"),
    _put("HOMF", "short", "home", "1 homes forward, in dial coordinates; 0 again at the end"),
    _put("HOMR", "short", "home", "1 homes back, in dial coordinates; 0 again at the end"),
    _put("JOGF", "short", "jog", "1 moves forward until 0, or to JVEL * 1 s before HLM"),
    _put("JOGR", "short", "jog", "1 moves back until 0, or to JVEL * 1 s before LLM"),
    _put("STUP", "enum", "update", "ON queries the position of the module, at rest, then returns to OFF", words=UPDATE),
    _put("NTM", "enum", "switch", "NO: a motion is not stopped for a new position", value=1, words=NO_YES),
    _fixed("NTMF", "long", 2, "no effect: the position is not known while the motor moves"),
    # state
    _fixed("LOCK", "enum", 0, "NO: for soft channels", words=NO_YES),
    _read("RCNT", "short", f"0: {_OPEN_LOOP}"),
    _read("MISS", "short", "1: a move has ended RDBD or more from DVAL"),
    _read("MSTA", "double", "bits 1 direction, 2 done, 10 problem, 11 moving, 13 no communication, 15 homed"),
    _read("TDIR", "short", "direction in steps: 1 up, 0 down"),
    _read("CDIR", "short", "the same as TDIR"),
    _read("RVEL", "long", "0: the module does not report its rate"),
    _read("ATHM", "short", "0: the module does not report its home switch"),
    _read("MIP", "long", "motion in progress: 0 none, 1 JOGF, 2 JOGR, 8 HOMF, 16 HOMR, 32 a move"),
    _read("PP", "short", "0"),
    _read("MOVN", "short", "1: the motor moves"),
    _read("DMOV", "short", "0: a motion is requested or in progress; 1/0/1 for every put of a position", value=1),
    # accuracy
    _put("RDBD", "double", "number", "distance from DVAL at which MISS is 1; at least MRES"),
    _fixed("SPDB", "double", 0.0, "even a move of one step is made"),
    _fixed("RTRY", "short", 0, _OPEN_LOOP),
    _fixed("RMOD", "enum", 0, _OPEN_LOOP, words=RETRY),
    _put("DLY", "double", "number", "time at rest before DMOV is 1", unit=TIME),
    # functions that the module lacks
    _fixed("CNEN", "enum", 0, "Disable: the torque cannot be switched", words=("Disable", "Enable")),
    _fixed("PCOF", "double", 0.0, "no position loop", unit=NONE),
    _fixed("ICOF", "double", 0.0, "no position loop", unit=NONE),
    _fixed("DCOF", "double", 0.0, "no position loop", unit=NONE),
    _fixed("INIT", "string", "", "commands are not passed on"),
    _fixed("PREM", "string", "", "commands are not passed on"),
    _fixed("POST", "string", "", "commands are not passed on"),
    _fixed("OMSL", "enum", 0, _LINK, words=("supervisory", "closed_loop")),
    *(_fixed(name, "string", "", _LINK) for name in ("DOL", "RDBL", "RLNK", "DINP", "RINP", "STOO", "FLNK", "SDIS")),
    # alarms
    *(_fixed(name, "double", 0.0, _UNUSED) for name in ("HIHI", "LOLO", "HIGH", "LOW")),
    *(_fixed(name, "enum", 0, _UNUSED, words=SEVERITY) for name in ("HHSV", "LLSV", "HSV", "LSV")),
    _fixed("HLSV", "enum", 0, _NO_SWITCH, words=SEVERITY),
    _fixed("MDEL", "double", 0.0, "every change of RBV is posted"),
    _fixed("ADEL", "double", 0.0, "every change of RBV is posted"),
    _read("STAT", "enum", "COMM while the module does not answer", words=STATUS),
    _read("SEVR", "enum", "INVALID while the module does not answer", words=SEVERITY),
    # of every record
    _put("DISP", "short", "number", "1: puts into other fields are refused", unit=NONE),
    _put("_able", "enum", "disable", "DISP as a separate record: NAME_able", words=("Enable", "Disable")),
    _fixed("DISA", "short", 0, "the record is not disabled"),
    _fixed("DISV", "short", 1, "the record is not disabled"),
    _put("DESC", "string", "text", "a text; initially the part and its port"),
    _put("EGU", "string", "text", "unit: `--units`"),
    _put("PREC", "short", "number", "decimals that clients show", unit=NONE),
    _read("NAME", "string", "`--record`"),
    _read("RTYP", "string", "motor", value="motor"),
    _read("DTYP", "string", "slewline", value="slewline"),
    _read("OUT", "string", "@ and the port of the module"),
    _read("CARD", "short", "-1: no card", value=-1),
    _read("VERS", "float", "version of the motor record with these fields", value=7.3, unit=NONE),
)  # fmt: skip
ROWS = {row.name: row for row in FIELDS}
