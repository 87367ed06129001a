"""The CY525: sheet, law of motion, handlers, linter, ramps, quirks."""
