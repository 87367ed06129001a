"""Classes of chips and parts, found by name: built-in, provided by an installed package, or in any module.

    the name of a part    a built-in class
    mx10                  an entry point of a package that the user has installed
    my_lab.mx10:Mx10      module:Class

Importing a module runs its code.  A name that the user enters, on the command line or as an argument, is
trusted.  A bench file, a journal or a URL may come from anywhere: the code that reads a name from such a
source decides whether the form module:Class is allowed (`allow_code`).  Entry points of packages that
the user has installed are always allowed.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib import import_module
from types import TracebackType
from typing import TYPE_CHECKING, Any, Generic, TypeVar
from weakref import WeakKeyDictionary

from ...errors import UnknownName, UsageError
from ..messages.near import hint

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

T = TypeVar("T")


class Catalogue(Generic[T]):
    """All classes of one kind, such as all chips, which are found by name.

    Args:
        what: the noun for the kind, such as "chip".
        base: the base class of all classes of this kind.
        group: the entry point group for further classes from packages.
        ours: the built-in classes, as module:Class, keyed by name.
        spelled: a function that returns a name in the spelling used in `ours`.
    """

    def __init__(
        self,
        what: str,
        base: type[T],
        group: str,
        ours: Mapping[str, str],
        spelled: Callable[[str], str] = str,
    ) -> None:
        self.what, self.base, self.group, self.ours, self.spelled = what, base, group, ours, spelled
        self._plug_ins: WeakKeyDictionary[type[T], str] = WeakKeyDictionary()  # names; a search for one takes 10 ms

    def load(self, name: str, *, allow_code: bool) -> type[T]:
        """Return the class that a name denotes.

        Args:
            allow_code: allow the form module:Class, which imports the module.

        Raises:
            UnknownName: no class has this name; the message lists the names.
            UsageError: the form module:Class is not allowed, there is no such module or class, the class is of
                another kind, or the module fails when it is imported.
        """
        key = self.canonical(name)
        if key in self.ours:
            module, _, attribute = self.ours[key].partition(":")
            return getattr(import_module(module), attribute)  # type: ignore[no-any-return]
        if ":" in key:
            if not allow_code:
                raise UsageError(
                    f"{self.what} {key!r}: names a module, and importing it would run its code; if you trust it, allow "
                    f"the import (allow_code=True, --allow-code), or install it with an entry point {self.group}"
                )
            return self._imported(key, f"{self.what} {key!r}")
        brought = self.brought_as(key)
        if brought is None:
            raise self.unknown(name)
        return self._imported(brought.value, f"{self.what} {key!r} of {package(brought)} ({brought.value})")

    def canonical(self, name: str) -> str:
        """Return the stored form of a name: module:Class unchanged, any other name as spelled in `ours`.

        Raises:
            UnknownName: the name is not text.
        """
        if not isinstance(name, str):
            raise self.unknown(name)
        return name if ":" in name else self.spelled(name)

    def name_of(self, cls: type[T]) -> str:
        """Return the name by which a class is found: a built-in name, the name of an entry point, or module:Class."""
        place = f"{cls.__module__}:{cls.__qualname__}"
        names = [name for name, ours in self.ours.items() if ours == place]
        if len(names) == 1:  # a class with several names does not itself state any of them
            return names[0]
        if cls not in self._plug_ins:
            alone = {found[0].value: name for name, found in self.brought().items() if len(found) == 1}
            self._plug_ins[cls] = alone.get(place, place)
        return self._plug_ins[cls]

    def names(self) -> list[str]:
        """Return all names: first the built-in ones, then those from installed packages."""
        return [*self.ours, *self.brought()]

    # ------------------------------------------------------------------------------------------- installed packages
    def brought(self) -> dict[str, list[EntryPoint]]:
        """Return the entry points of installed packages, in lists keyed by name: packages may share a name."""
        from importlib.metadata import entry_points  # it takes long to load, and most runs use built-in classes

        found: dict[str, list[EntryPoint]] = {}
        for point in sorted(entry_points(group=self.group), key=lambda point: point.name):
            name = self.spelled(point.name)
            if name not in self.ours and point.value not in [other.value for other in found.get(name, ())]:
                found.setdefault(name, []).append(point)
        return found

    def brought_as(self, name: str) -> EntryPoint | None:
        """Return the entry point of this name; None if no installed package has one.

        Raises:
            UsageError: several packages have an entry point with this name.
        """
        found = self.brought().get(name, [])
        if len(found) > 1:
            places = ", ".join(f"{package(point)} ({point.value})" for point in found)
            raise UsageError(f"{self.what} {name!r}: several packages provide it: {places}; give module:Class instead")
        return found[0] if found else None

    def unknown(self, name: object) -> UnknownName:
        """Return the error to raise for an unknown name; its message lists all names."""
        names = self.names()
        remedy = hint(self.spelled(str(name)), names)
        if str(name).endswith(".toml"):
            remedy = f"; it is a bench file: slewline serve --bench {name}, or slewline.load({name!r})"
        elif not remedy and "." in str(name):
            remedy = f"; a class of your own is module:Class, such as {name}:Class"
        return UnknownName(f"no {self.what} {name!r}; available: {', '.join(names)}{remedy}")

    # --------------------------------------------------------------------------------------------------- any module
    def _imported(self, place: str, places: str) -> type[T]:
        """Import and return the class that `place` names as module:Class; error messages begin with `places`."""
        module, _, attribute = place.partition(":")
        if "<locals>" in attribute:
            raise UsageError(
                f"{places}: a class within a function cannot be found by name; move it out of the function"
            )
        if not all(part.isidentifier() for part in [*module.split("."), *attribute.split(".")]):
            raise UsageError(f"{places}: expected module:Class, such as my_lab.mx10:Mx10")
        try:
            found: Any = import_module(module)
        except ModuleNotFoundError as error:
            if error.name is None or not f"{module}.".startswith(f"{error.name}."):
                raise UsageError(f"{places}: {failed(module, error)}") from error
            raise UsageError(
                f"{places}: no module {error.name!r}; install its package, or add its directory to PYTHONPATH"
            ) from None
        except (Exception, SystemExit) as error:  # any error: the code of the module is not ours
            raise UsageError(f"{places}: {failed(module, error)}") from error
        for part in attribute.split("."):
            if not hasattr(found, part):
                raise UsageError(f"{places}: {module} has no {attribute!r}{self._classes_in(import_module(module))}")
            found = getattr(found, part)
        if not (isinstance(found, type) and issubclass(found, self.base)):
            what = "a class" if isinstance(found, type) else f"of type {type(found).__name__}"
            expected = f"expected a subclass of {self.base.__module__}.{self.base.__name__}"
            raise UsageError(f"{places}: {attribute} is {what}; {expected}{self._classes_in(import_module(module))}")
        return found

    def _classes_in(self, module: object) -> str:
        """Return text that lists the classes of this kind that a module defines; empty if there are none."""
        names = [
            name
            for name, cls in vars(module).items()
            if isinstance(cls, type)
            and issubclass(cls, self.base)
            and cls.__module__ == getattr(module, "__name__", "")
        ]
        return f"; its {self.what}s: {', '.join(names)}" if names else ""


def package(point: EntryPoint) -> str:
    """Return the name and the version of the package that an entry point belongs to."""
    return f"{point.dist.name} {point.dist.version}" if point.dist is not None else "a package"


def failed(module: str, error: BaseException) -> str:
    """Return a description of an error that was raised during the import of a module, with file and line."""
    at = ""
    if isinstance(error, SyntaxError) and error.filename:
        at = f" ({error.filename}, line {error.lineno})"
    elif error.__traceback__ is not None:
        last = _last(error.__traceback__)
        at = f" ({last.tb_frame.f_code.co_filename}, line {last.tb_lineno})"
    message = error.msg if isinstance(error, SyntaxError) else str(error)
    return f"importing {module} failed: {type(error).__name__}{f': {message}' if message else ''}{at}"


def _last(trace: TracebackType) -> TracebackType:
    """Return the last link of a traceback, which is for the innermost frame."""
    while trace.tb_next is not None:
        trace = trace.tb_next
    return trace
