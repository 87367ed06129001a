"""The symbolic link under which a device is found.

A new link replaces only an old link made by slewline.  The folder of the link is kept open until the link is removed,
so that no other folder can take its place meanwhile.  If a bench file names the path of the link, that path, which
begins at the folder of the bench file, may not lead through another symbolic link.
"""

from __future__ import annotations

import os
import re
import stat
from contextlib import suppress
from pathlib import Path

from ...errors import UsageError
from ...gate import LinkPlace
from ..sockets.system import FOLDER, NO_LINK

DEVICE = re.compile(r"/dev/(?:pts/|ttys)[0-9]+")  # of Linux, of macOS


class DeviceLink:
    """A link to a device; the link exists until `remove`.

    Args:
        place: the path of the link, if given by a user; if named in a bench file, its `LinkPlace`.
        target: the device.

    Raises:
        UsageError: the link cannot be made, or its name is in use and is not an old link made by slewline.
    """

    def __init__(self, place: str | LinkPlace, target: str) -> None:
        self.path, self.target = Path(str(place)), target
        if not isinstance(place, LinkPlace):
            place = LinkPlace(self.path.parent, (), self.path.name)
        self.name = place.name
        try:
            self._folder = _entered(place)
        except OSError as error:
            raise self._refused(error) from None
        try:
            self._make()
        except OSError as error:
            os.close(self._folder)
            raise self._refused(error) from None
        except BaseException:
            os.close(self._folder)
            raise

    def _make(self) -> None:
        with suppress(FileNotFoundError):
            mode = os.lstat(self.name, dir_fd=self._folder).st_mode
            target = os.readlink(self.name, dir_fd=self._folder) if stat.S_ISLNK(mode) else ""
            if not DEVICE.fullmatch(target):
                raise UsageError(
                    f"{self.path}: this exists and is not an old link made by slewline; choose another path"
                )
            if not self._stale(target):
                raise UsageError(
                    f"{self.path}: this link points to {target}, a terminal that is in use, for example by another "
                    "server; choose another path, or first end the program that uses the terminal"
                )
            os.unlink(self.name, dir_fd=self._folder)
        os.symlink(self.target, self.name, dir_fd=self._folder)

    def _stale(self, target: str) -> bool:
        """Return whether a link to `target` was left by a killed server: `target` is gone, or now our device."""
        return target == self.target or not os.path.exists(target)

    def _refused(self, error: OSError) -> UsageError:
        return UsageError(
            f"{self.path}: {error.strerror}; put the link in a writable directory, and not in one that is itself a link"
        )

    def remove(self) -> None:
        """Remove the link, unless another program has replaced it."""
        with suppress(OSError):
            if os.readlink(self.name, dir_fd=self._folder) == self.target:
                os.unlink(self.name, dir_fd=self._folder)
        os.close(self._folder)


def _entered(place: LinkPlace) -> int:
    """Open the folder of a link, following no link below `place.folder`; return its descriptor."""
    folder = os.open(place.folder, os.O_RDONLY | FOLDER)
    for each in place.below:
        above = folder
        try:
            folder = os.open(each, os.O_RDONLY | FOLDER | NO_LINK, dir_fd=above)
        finally:
            os.close(above)
    return folder
