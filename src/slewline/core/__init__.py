"""The pure part of the house: integers in, waveforms out.  No wall clock, no file, no socket, no thread."""
