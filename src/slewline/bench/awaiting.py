"""A bench in asyncio: what it asks of the loop in which somebody waits for it (testing/aio.py has such a loop)."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any, Protocol, cast

from ..errors import UsageError

if TYPE_CHECKING:
    from ..core.wires.net import Net


class VirtualLoop(Protocol):
    """A loop in which virtual time passes while all tasks wait."""

    async def passed(
        self, bench: Any, met: Callable[[], bool], when: Callable[[], int | None] | None, nets: Iterable[Net], ps: int
    ) -> bool:
        """Wait until a condition is met, for so much of the bench's time; return whether it was."""


def virtual_loop(verb: str) -> VirtualLoop:
    """Return the loop that runs here.

    Raises:
        UsageError: it goes by the wall clock.
    """
    import asyncio

    loop = asyncio.get_running_loop()
    if not hasattr(loop, "passed"):
        raise UsageError(
            f"await bench.{verb}(): this loop of asyncio goes by the wall clock; start the program with "
            'slewline.testing.aio.run(main()), or anyio.run(main, backend_options={"loop_factory": VirtualLoop})'
        )
    return cast(VirtualLoop, loop)
