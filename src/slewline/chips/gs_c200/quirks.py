"""Where the GS-C200 data sheet is silent or contradicts itself: what the module does, why, which test pins it.  Data only.

UND: the sheet leaves it open.  CON: two places of the sheet disagree.
"""

from __future__ import annotations

from ...core.quirk import Quirk as _Q

# fmt: off
QUIRKS = (
    # ----------------------------------------------------------------------------------- line, address, checksum, answers
)
# fmt: on
