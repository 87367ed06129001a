"""What `slewline` and `slewline.build` export is loaded when it is asked for."""

from __future__ import annotations

import subprocess
import sys

import pytest

import slewline
import slewline.build


def loaded(statement: str) -> set[str]:
    """The modules of slewline that a statement loads."""
    code = f"import sys; {statement}; print(*(name for name in sys.modules if name.startswith('slewline')))"
    return set(subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True).stdout.split())


def test_what_is_asked_for_is_loaded_and_nothing_else() -> None:
    light = {"slewline", "slewline.lazy", "slewline.version"}
    assert loaded("import slewline") == light
    assert loaded("import slewline.build") == {*light, "slewline.build"}
    assert "slewline.core.table" in (sheet := loaded("from slewline.build import Row, Sheet"))
    assert not sheet & {"slewline.core.chip", "slewline.parts", "slewline.chips", "slewline.bench"}


@pytest.mark.parametrize("face", [slewline, slewline.build])
def test_a_face_has_the_names_that_it_lists_and_no_others(face) -> None:
    assert set(face.__all__) - {"__version__"} <= set(dir(face))
    for name in face.__all__:
        assert getattr(face, name) is vars(face)[name]  # it stays there
    with pytest.raises(AttributeError, match=f"module '{face.__name__}' has no attribute 'nonsense'"):
        face.nonsense  # noqa: B018
