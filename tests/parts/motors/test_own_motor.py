"""A motor of one's own: its figures as text, what is missing, what is assumed."""

from __future__ import annotations

import pytest

import slewline
from slewline.errors import UnknownName, UsageError
from slewline.parts.motors.motors import (
    ASSUMED,
    EXAMPLE,
    FIGURES,
    MOTORS,
    NEEDED,
    SPELLED,
    assumptions,
    read_motor,
)
from tests.rows import rows

UNIT_OF = {row.name: row.unit for row in FIGURES}
TABLE = {"current": "2 A", "resistance": "1.4 ohm", "inductance": "3 mH", "torque": "0.44 Nm", "inertia": "57 g cm2"}
LONG = (
    "Rated current: 2 A, phase resistance=1.4 ohm, phase inductance 3 mH, holding torque 44 Ncm, rotor inertia 57 gcm2"
)


def without(figure: str) -> str:
    """The example without a figure."""
    return ", ".join(part for part in EXAMPLE.split(", ") if figure not in part)


@rows(
    "text",
    [
        EXAMPLE,
        LONG,
        EXAMPLE.upper().replace("OHM", "ohm").replace(" MH", " mH").replace("NM", "Nm").replace("G CM", "g cm"),
    ],
)
def test_text_is_the_same_motor_as_the_table(text):
    assert read_motor(text) == read_motor(TABLE)


def test_text_may_be_like_a_motor_with_a_name():
    assert read_motor("like AS1010, inertia 80 g cm2, name z axis") == read_motor(
        {"like": "AS1010", "inertia": "80 g cm2", "name": "z axis"}
    )


@rows("row", FIGURES)
def test_every_figure_can_be_written_as_text(row):
    words = {"choice": row.choices[-1:], "int": (7,), "text": ("Some Text",)}.get(row.kind, (f"0.25 {row.unit}",))
    if row.name in ("windings", "swing", "phases"):
        found = read_motor(f"windings reluctance, phases 3, swing 0.25 mH, {without('torque')}")
        assert (found.windings, found.swing, found.phases) == ("reluctance", 0.25e-3, 3)
        return
    others = {"torque": "1 Nm"} | {name: of for name, of in TABLE.items() if name not in (row.name, "torque")}
    others.pop(row.name, None)
    text = ", ".join([f"{row.name} {words[0]}", *(f"{name} {of}" for name, of in others.items())])
    assert getattr(read_motor(text), row.name) == (0.25 if row.kind == "quantity" else words[0])


@rows("word", SPELLED)
def test_figures_have_the_names_of_data_sheets(word):
    figure, _, value = SPELLED[word].partition(" ")
    if figure in TABLE:
        assert read_motor(f"{without(figure)}, {word} {TABLE[figure]}") == read_motor(TABLE)
    elif value == "reluctance":
        assert read_motor(f"{word}, swing 1 mH, {EXAMPLE}").windings == value
    elif value:
        assert getattr(read_motor(f"{word}, {EXAMPLE}"), figure) == value
    elif figure == "step_angle":
        for angle, steps in (("1.8", 200), ("0.9 deg", 400), ("1.8°", 200), ("15 deg", 24), ("0.0314159265 rad", 200)):
            assert read_motor(f"{EXAMPLE}, {word} {angle}").full_steps == steps
    else:
        assert getattr(read_motor(f"{EXAMPLE}, {word} 0.01 {UNIT_OF[figure]}"), figure) == 0.01


def test_all_that_is_missing_is_named_with_its_unit_and_an_example():
    units = {row.name: row.unit for row in FIGURES}
    for n, one in enumerate(NEEDED):
        for other in NEEDED[n:]:
            left = {name: of for name, of in TABLE.items() if name not in (one, other)}
            for motor in (left, ", ".join(f"{name} {of}" for name, of in left.items())):
                with pytest.raises(UsageError) as error:
                    read_motor(motor, "--motor")
                says = str(error.value)
                assert says.startswith(f"--motor needs {one} ({units[one]}: ") and says.count("for example") == 1
                assert f"{other} ({units[other]}: " in says and EXAMPLE in says
                assert not any(f"{name} ({units[name]}: " in says for name in left)


def test_every_figure_is_needed_or_has_a_documented_assumption():
    neither = {row.name for row in FIGURES} - set(NEEDED) - set(ASSUMED)
    assert neither == {"name", "source", "swing", "phases"}  # words, and figures of reluctance motors
    assert assumptions(EXAMPLE) == assumptions(TABLE) == tuple(ASSUMED.values())
    for figure, value in (("windings", "unipolar"), ("step_angle", "0.9 deg"), ("rated", "one"), ("iron", 1e-3)):
        gone = ASSUMED["teeth" if figure == "step_angle" else figure]
        assert gone not in assumptions(TABLE | {figure: value}) and gone not in assumptions(
            f"{EXAMPLE}, {figure} {value}"
        )
    reluctance = f"windings reluctance, swing 1 mH, {without('torque')}"
    assert assumptions(reluctance) == (ASSUMED["detent"], ASSUMED["viscous"], ASSUMED["friction"])
    for named in ("AS1010", {"like": "AS1010", "inertia": "80 g cm2"}, read_motor(TABLE)):
        assert assumptions(named) == ()


def test_assumed_values_are_those_of_the_model():
    motor = read_motor(TABLE)
    assert (motor.windings, motor.full_steps, motor.rated) == ("bipolar", 200, "two")
    assert (motor.detent, motor.viscous, motor.friction) == (0.0, 0.0, 0.0)
    assert motor.drag == pytest.approx(2.66e-3 * 0.44) and "2.66 ms" in ASSUMED["iron"] and "1.8" in ASSUMED["teeth"]


@rows(
    ("text", "says"),
    [
        (EXAMPLE.replace("0.44", "0,44"), "'44 Nm' has no name; write the name, the number (with a decimal point)"),
        (EXAMPLE.replace("0.44 Nm", "4 kg"), "m: torque '4 kg'; kg is a unit of mass; allowed 0 or more N m, or text"),
        (EXAMPLE.replace("3 mH", "3 mNm"), "m: inductance '3 mNm'; mNm is a unit of torque; allowed a number (H)"),
        (f"{EXAMPLE}, current 1 A", "current is given twice; leave one out"),
        (f"{EXAMPLE}, rated current 1 A", "current is given twice; leave one out"),
        (f"{EXAMPLE}, curent 1 A", "m: no option 'curent'; its options: name, windings"),
        (f"{EXAMPLE}, step angle 7 deg", "m: step_angle '7 deg'; expected 90 deg divided by a whole number"),
        (f"{EXAMPLE}, step angle 0 deg", "m: step_angle '0 deg'; expected 90 deg divided by a whole number"),
        (f"{EXAMPLE}, step angle 1.8 deg, teeth 50", "m: step_angle and teeth both set the full steps per revolution"),
        (f"{EXAMPLE}, inertia", "inertia is given twice"),
        (f"reluctance, swing 1 mH, step angle 15 deg, {EXAMPLE}", "step_angle does not apply to a reluctance motor"),
        (f"{without('inertia')}, inertia", "m: inertia ''; allowed a number (kg m2)"),
    ],
)  # fmt: skip
def test_a_text_that_cannot_be_is_refused(text, says):
    with pytest.raises(UsageError) as error:
        read_motor(text, "m")
    assert says in str(error.value)


@rows("name", ["17HE19-2004S", "17HE19-2004S1", "17HS19-2004S2", "QSH4218-51-10-48", "AS101", "NEMA 17"])
def test_another_motor_is_not_offered_for_an_unknown_one(name):
    with pytest.raises(UnknownName) as error:
        read_motor(name, "--motor")
    assert "did you mean" not in str(error.value)
    assert str(error.value).endswith(f"; for another motor use the figures of its data sheet: '{EXAMPLE}'")


@rows("name", MOTORS)
def test_the_same_part_number_spelled_otherwise_is_offered(name):
    for spelled in (
        name.lower(),
        name.replace("-", ""),
        name.replace("-", " ").lower(),
        name[:-2] + name[-1] + name[-2],
    ):
        if spelled in MOTORS:
            continue
        with pytest.raises(UnknownName, match=f"; did you mean {name}\\?"):
            read_motor(spelled)


def test_a_bench_takes_the_text():
    bench = slewline.Bench()
    x = bench.add("cy525", name="x")
    bench.part("stepper", name="motor", to=x, motor=f"{EXAMPLE}, name mine", driver="24 V, 1 A")
    with pytest.raises(UsageError, match="; needs torque "):
        bench.part("stepper", name="other", to=x, motor=without("torque"), driver="24 V, 1 A")
    assert slewline.motor_law(EXAMPLE).motor == read_motor(TABLE)
