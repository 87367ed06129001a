"""Sphinx: entries of the API from Google docstrings, and names of ours that lead to their entries.

A signature says `Terminal` or, where types were worked out, `slewline.core.wires.pin.Terminal`; the entry is that of
`slewline.build.Terminal`.  Its last word finds it, because names of classes are unique.
"""

from __future__ import annotations

import inspect
import re
from typing import Any

from docutils import nodes
from sphinx.ext.autodoc.preserve_defaults import update_default_value
from sphinx.ext.napoleon import Config, GoogleDocstring
from sphinx.util.nodes import make_refnode

OBJECT = re.compile(r"<(?:factory|function [^>]*)>")
MODULE = re.compile(r"\b[a-z_.]+\.(?=[A-Z])")
ALIAS = re.compile(r"TypeAliasForwardRef\('(\w+)'\)")
NAME = re.compile(r"[\w.]*")
OWNERS = {  # what pages call an object of a class
    "bench": "slewline.Bench",
    "x": "slewline.Chip",
    "pin": "slewline.build.Terminal",
    "host": "slewline.parts.hosts.host.Host",
    "drive": "slewline.Drive",
    "steps": "slewline.Steps",
    "motion": "slewline.core.motion.motions.MotionStart",
    "waveforms": "slewline.record.waveforms.waveforms.Waveforms",
}
FACES = ("slewline.build", "slewline")
OF_NAMES = ("reference/build", "reference/api")  # pages on which a name without an owner is one of ours
CLASSES = ("class", "exception", "type")
STYLE = Config(napoleon_numpy_docstring=False, napoleon_use_param=False, napoleon_use_rtype=False)


def parsed(app: Any, what: str, name: str, obj: Any, options: Any, lines: list[str]) -> None:
    """Turn a docstring into fields.

    The extension sphinx.ext.napoleon does the same, but takes what stands before a colon in the docstring of a property
    for its type.
    """
    what = "method" if what == "property" else what
    fields, found = GoogleDocstring(lines, STYLE, app, what, name, obj, options).lines(), []
    for line in (each.replace(" -- ", " – ") for each in fields):  # the type of an attribute stands with its name
        if line.startswith("   :type:") and ".. attribute::" in (heads := [one[:14] for one in found]):
            found.insert(len(heads) - heads[::-1].index(".. attribute::"), MODULE.sub("", line))
        else:
            found.append(line)
    lines[:] = found


def as_written(_app: Any, obj: Any, bound: bool) -> None:
    """Keep defaults as the source has them, such as `POLL`.

    `autodoc_preserve_defaults` does the same, but fails where the signature lists options that the source unpacks.
    """
    if not hasattr(inspect.unwrap(obj), "__signature__"):
        update_default_value(obj, bound)


def readable(*event: Any) -> tuple[str | None, ...]:
    """Return a signature without defaults that nobody can write, such as `<factory>`, and with names of types alone."""
    return tuple(part and ALIAS.sub(r"\1", OBJECT.sub("...", part)) for part in event[-2:])


def dashed(_app: Any, tree: Any) -> None:
    """Put a dash, which Sphinx leaves to smart quotes, between a parameter and what it is."""
    for text in list(tree.findall(nodes.Text)):
        if text == " -- ":
            text.parent.replace(text, nodes.Text(" – "))


def entry_of(app: Any, env: Any, node: Any, contnode: Any) -> Any:
    """Return a link to the entry of a class, found by the last word of its name; None: there is no such entry."""
    if node.get("refdomain") != "py":
        return None
    word = node["reftarget"].rpartition(".")[2]
    name = _class_called(env, word)
    return _link(app, node["refdoc"], name, contnode) if name else None


def _class_called(env: Any, word: str) -> str:
    """Return the full name of a class; "": there is no entry of such a one."""
    every = env.domains.python_domain.objects.items()
    return next((name for name, found in every if found.objtype in CLASSES and name.rpartition(".")[2] == word), "")


def _link(app: Any, page: str, name: str, shown: Any) -> Any:
    found = app.env.domains.python_domain.objects[name]
    return make_refnode(app.builder, page, found.docname, found.node_id, shown, name)


def link_code(app: Any, tree: Any, page: str) -> None:
    """Let code on a page lead to the entry of what it names: `bench.run("1 ms")`, `slewline.ramp`, `Sheet`."""
    objects = app.env.domains.python_domain.objects
    for code in list(tree.findall(nodes.literal)):
        owner, dot, member = (name := NAME.match(code.astext())[0]).partition(".")
        full = f"{OWNERS[owner]}.{member}" if owner in OWNERS else name
        if not dot and page.startswith(OF_NAMES):
            of_faces = (f"{face}.{name}" for face in FACES)
            full = next((one for one in of_faces if one in objects), "") or _class_called(app.env, name)
        if full in objects and not isinstance(code.parent, (nodes.reference, nodes.title)):
            code.replace_self(_link(app, page, full, code.deepcopy()))


def setup(app: Any) -> dict[str, bool]:
    """Register all of it."""
    app.connect("autodoc-process-docstring", parsed)
    app.connect("autodoc-before-process-signature", as_written)
    app.connect("autodoc-process-signature", readable)
    app.connect("doctree-read", dashed)
    app.connect("missing-reference", entry_of)
    app.connect("doctree-resolved", link_code)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
