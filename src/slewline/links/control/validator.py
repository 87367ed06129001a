"""The validator of requests; for a value outside the schema, the error states place, value and remedy.

A kind is a JSON schema with these keywords: `type`, `enum`, `const`, `minimum`, `maximum`, `pattern`,
`maxLength`, `items`, `maxItems`, `properties` with `required` and `additionalProperties`, and `oneOf`
with several objects, one of which is selected by the keys of the value.  Beyond JSON schema, a text with
a pattern and a range is a quantity, whose value must be in the range.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Mapping
from math import isfinite
from typing import Any

from ...core.messages.near import hint
from ...core.time.timebase import PS_PER_S, moment
from ...errors import UsageError
from .value_kinds import A_RATE, A_TIME, Data

LONGEST = 60  # characters of a text that a message shows
PS_PER_DAY = 86_400 * PS_PER_S
DEEPEST = 16  # objects and lists in one another
MEASURES: Mapping[str, Callable[[str], float]] = {A_TIME: moment, A_RATE: float}  # what a text of a pattern measures
TYPES: Mapping[str, type | tuple[type, ...]] = {
    "string": str,
    "integer": int,
    "number": (int, float),
    "array": list,
    "object": dict,
}
NAMES = {
    "string": "text",
    "integer": "a whole number",
    "number": "a number",
    "boolean": "true or false",
    "array": "a list",
    "object": "an object",
    "null": "null",
}


def as_object(line: bytes) -> Data:
    """Return the JSON object in a line.

    Raises:
        UsageError: the line is not an object, has a number that JSON forbids, or is nested too deeply.
    """
    try:
        found = json.loads(line, parse_constant=_refuse, parse_float=_finite)
    except (ValueError, RecursionError):
        found = None
    if not isinstance(found, dict):
        text = shown(line.decode("utf-8", "replace"))
        raise UsageError(f'{text} is not a JSON object; expected a line such as {{"do": "status"}}')
    if deeper(found, DEEPEST):
        raise UsageError(f"the request is nested more than {DEEPEST} levels deep; send a flatter one")
    return found


def _refuse(name: str) -> float:
    raise ValueError(name)  # NaN, Infinity


def _finite(text: str) -> float:
    if not isfinite(found := float(text)):
        raise ValueError(text)
    return found


def deeper(value: object, levels: int) -> bool:
    """Return whether the objects and lists in a value are nested more deeply than `levels`."""
    inner = value.values() if isinstance(value, dict) else value if isinstance(value, list) else None
    return inner is not None and (not levels or any(deeper(each, levels - 1) for each in inner))


def check(value: Any, kind: Data, place: str) -> Any:
    """Return a value after checking it against a kind; where the kind is an integer, 1.0 becomes 1.

    Args:
        place: the place of the value in the request, for messages: the verb and the keys.

    Raises:
        UsageError: the value is not of this kind.
    """
    if "oneOf" in kind:
        return check(value, chosen(value, kind["oneOf"], place), place)
    types = kind.get("type")
    if isinstance(types, str):
        types = [types]
    if "integer" in (types or ()) and isinstance(value, float) and value.is_integer():
        value = int(value)
    if types is not None and not any(is_of(value, name) for name in types):
        raise refusal(place, value, kind)
    if "enum" in kind:
        same = [each for each in kind["enum"] if each == value and isinstance(each, bool) is isinstance(value, bool)]
        if not same:
            raise refusal(place, value, kind)
        return same[0]
    if isinstance(value, dict):
        return checked_object(value, kind, place)
    if isinstance(value, list):
        if len(value) > kind.get("maxItems", len(value)):
            raise UsageError(f"{place}: a list of length {len(value)}; allowed up to {kind['maxItems']}")
        return [check(each, kind.get("items", {}), f"{place}[{number}]") for number, each in enumerate(value)]
    if isinstance(value, str):
        if len(value) > kind.get("maxLength", len(value)):
            raise UsageError(f"{place}: text of {len(value)} characters; allowed up to {kind['maxLength']}")
        if "pattern" in kind and not re.search(kind["pattern"], value):
            raise refusal(place, value, kind)
    check_range(value, kind, place)
    return value


def check_range(value: Any, kind: Data, place: str) -> None:
    """Check the range of a number, or of the quantity in a text.

    Raises:
        UsageError: the value is out of range.
    """
    if isinstance(value, str):
        if "minimum" not in kind:
            return
        try:
            number = MEASURES[kind["pattern"]](value)
        except UsageError as error:
            raise UsageError(f"{place}: {str(error).removeprefix('time ')}") from None
    elif isinstance(value, int | float) and not isinstance(value, bool):
        number = value
    else:
        return
    if not kind.get("minimum", number) <= number <= kind.get("maximum", number):
        raise refusal(place, value, kind)


def checked_object(value: Data, kind: Data, place: str) -> Data:
    """Return an object with its values checked.

    Raises:
        UsageError: a key is missing or unknown, or a value is of the wrong kind.
    """
    keys, needed = kind.get("properties", {}), kind.get("required", ())
    for name in needed:
        if name not in value:
            raise UsageError(f"{place} needs {listed(needed)}; {name} is missing")
    if kind.get("additionalProperties") is False:
        check_names(value, keys, place)
    return {name: check(each, keys[name], at(place, name)) if name in keys else each for name, each in value.items()}


def check_names(value: Data, keys: Mapping[str, Any], place: str) -> None:
    """Check that an object has only known keys.

    Raises:
        UsageError: a key is unknown.
    """
    for name in value:
        if name not in keys:
            raise UsageError(f"{place}: {shown(name)} is unknown; allowed {listed(keys)}{hint(name, keys)}")


def chosen(value: Any, forms: list[Data], place: str) -> Data:
    """Return the form whose keys match those of a value; if there is only one form, return it unchecked.

    Raises:
        UsageError: there are several forms, and the value is not an object or its keys match none of them.
    """
    if len(forms) == 1:
        return forms[0]
    if not isinstance(value, dict):
        raise UsageError(f"{place}: {shown(value)}; expected an object")
    check_names(value, {name: None for form in forms for name in form["properties"]}, place)
    for form in forms:
        if set(form["required"]) <= set(value) <= set(form["properties"]):
            return form
    raise UsageError(f"{place}: found {listed(value)}; give {'; or '.join(map(keys_of, forms))}")


def keys_of(form: Data) -> str:
    """Return the keys of a form as text, optional ones in brackets, without those common to all requests."""
    return ", ".join(name if name in form["required"] else f"[{name}]" for name in own(form["properties"]))


def own(keys: Mapping[str, Any] | list[str]) -> list[str]:
    """Return keys without `do`, `id` and `token`, which are common to all requests."""
    return [name for name in keys if name not in ("do", "id", "token")]


def listed(keys: Mapping[str, Any] | list[str]) -> str:
    """Return keys as text, without those common to all requests; "nothing" if none are left."""
    return ", ".join(own(keys)) or "nothing"


def at(place: str, name: str) -> str:
    """Return the place of a key's value, given the place of the object: "drive: level", "find: on.pin"."""
    return f"{place}.{name}" if ": " in place else f"{place}: {name}"


def is_of(value: object, name: str) -> bool:
    """Return whether a value is of a JSON schema type; true and false are not numbers."""
    if isinstance(value, bool) or value is None:
        return name == ("null" if value is None else "boolean")
    return isinstance(value, TYPES.get(name, ()))


def refusal(place: str, value: object, kind: Data) -> UsageError:
    """Return the error for a value of the wrong kind."""
    return UsageError(f"{place}: {shown(value)}; {expected(kind)}")


def expected(kind: Data) -> str:
    """Return a description of the permitted values of a kind, for a message."""
    if "enum" in kind:
        return f"allowed {in_words(kind)}"
    what, reach = in_words(kind), span(kind)
    return f"expected {what}; allowed {reach}" if reach else f"expected {what}"


def in_words(kind: Data) -> str:
    """Return a description of the values of a kind, without their range."""
    if "enum" in kind:
        return ", ".join(map(str, kind["enum"]))
    if "oneOf" in kind:
        return f"an object with {'; or '.join(map(keys_of, kind['oneOf']))}"
    if kind.get("pattern") == A_TIME:
        return 'text with a unit such as "250 ms", or whole picoseconds'
    if "type" not in kind:
        return "anything"
    if kind["type"] == "array":
        return f"a list; each: {in_words(kind['items'])}"
    words = " or ".join(NAMES[name] for name in ([kind["type"]] if isinstance(kind["type"], str) else kind["type"]))
    return f"{words} such as {json.dumps(kind['examples'][0])}" if "examples" in kind else words


def span(kind: Data) -> str:
    """Return the range of a kind as text; "" if it has none."""
    if "minimum" not in kind:
        return ""
    if kind.get("pattern") == A_TIME:
        return f"0 to {kind['maximum'] // PS_PER_DAY} days"
    return f"{kind['minimum']} to {kind['maximum']}"


def shown(value: object) -> str:
    """Return the text for a value in a message, truncated if long.

    Lists and objects are not written out: "a list of length 3", "an object".
    """
    if isinstance(value, str):
        return repr(value) if len(value) <= LONGEST else f"{value[:LONGEST]!r}..."
    if isinstance(value, list):
        return f"a list of length {len(value)}"
    if isinstance(value, dict):
        return "an object"
    text = json.dumps(value)
    return text if len(text) <= LONGEST else f"{text[:LONGEST]}..."
