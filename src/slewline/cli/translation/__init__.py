"""The command that translates programs for another part or controller, and its report as text and as data."""
