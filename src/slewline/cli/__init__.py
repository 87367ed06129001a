"""The command line.  Its modules import only click; the other modules are imported when a command runs.

The name and the options of a command are in `commands.py`, or in the commands module of a subpackage;
another module in the same folder does the work of the command.  `tools/describe_docs.py` and
`tools/share.py` write the documentation page of the commands and the man page.  The templates of
`new-chip` and `new-part` are in templates/: the folder `both` holds the files common to both commands;
`chip` and `part` hold the others.  `packages/new_package.py` replaces words in all these files.
"""

FOUND, WRONG_USE = 1, 2  # exit status; 0: success


class Terminated(KeyboardInterrupt):
    """A request by the system to end the process.

    It is handled like Ctrl-C, but always ends the command, even where Ctrl-C cancels only the line being
    typed.
    """
