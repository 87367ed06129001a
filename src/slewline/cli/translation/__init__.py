"""The command `slewline translate`, with its reports: a program is rewritten for another part or controller."""
