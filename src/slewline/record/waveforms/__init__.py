"""Waveform files: value change dumps (VCD), written and read, tables (CSV), read, and layouts for viewers."""
