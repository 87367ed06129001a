"""The command that translates programs for another part or controller, with its report as text and as data."""
