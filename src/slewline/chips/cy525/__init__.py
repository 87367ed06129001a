"""The CY525: its sheet, law of motion, handlers, lint rules, ramp calculator and quirks."""
