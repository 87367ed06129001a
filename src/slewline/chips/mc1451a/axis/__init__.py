"""One axis: its trajectory generator, pulses, encoder, gear, limit switches and updates."""
