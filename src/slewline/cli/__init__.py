"""The command line.  Its modules load click and nothing heavy; what a command needs, it loads when it runs.

A command has its name and its options in `commands.py`, or in the module of commands of a room, and a module for its
work beside it.
`tools/describe_docs.py` and `tools/share.py` write its page and the man page.  Templates of `new-chip` and `new-part`
are in templates/: `both`, and what only a chip or a part has; `packages/new_package.py` replaces words in them.
"""

FOUND, WRONG_USE = 1, 2  # exit status; 0: all is well


class Terminated(KeyboardInterrupt):
    """The system asks the process to end: as Ctrl-C does, but not for a line alone."""
