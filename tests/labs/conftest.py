"""Motor records, and what is done with them in virtual time."""

from __future__ import annotations

import asyncio

import pytest

from tests.links.conftest import PATIENCE


@pytest.fixture
def run(monkeypatch):
    """Run what a client does with a record."""
    from tests.labs.watched import Watched  # whose library may be missing

    monkeypatch.setattr("slewline.labs.record.NEWS_S", 0)

    def run(play, **more):
        record = Watched(**more)
        try:
            asyncio.run(asyncio.wait_for(play(record), PATIENCE))
        finally:
            record.close()
        return record

    return run
