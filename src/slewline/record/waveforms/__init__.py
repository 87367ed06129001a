"""Waveform files: value change dumps, written and read, with layouts for viewers."""
