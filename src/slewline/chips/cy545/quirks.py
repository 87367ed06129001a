"""What we do not know of the CY545: most chapters of its manual are not readable.  What the model does, and why.

UND-...: no readable page tells.  CON-...: two places disagree.  Times hold at 12 MHz.  Data only.
"""

from __future__ import annotations

from .quirks_language import LANGUAGE
from .quirks_local_bus import LOCAL_BUS
from .quirks_motion import MOTION
from .quirks_sides import SIDES

QUIRKS = (*LANGUAGE, *SIDES, *LOCAL_BUS, *MOTION)
