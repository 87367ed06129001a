"""The core, built once as a library."""

from __future__ import annotations

import pytest

from . import library


@pytest.fixture(scope="session")
def core(tmp_path_factory):
    """The core as the compiler of this system makes it."""
    library.need()
    return library.Library(library.build(tmp_path_factory.mktemp("part")))
