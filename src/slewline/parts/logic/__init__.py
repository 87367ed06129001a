"""Gates, delay lines and latches, and the circuits around an oscillator."""
