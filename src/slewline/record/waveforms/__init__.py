"""Waveform files: value change dumps (VCD), written and read; tables (CSV), only read; layouts for viewers."""
