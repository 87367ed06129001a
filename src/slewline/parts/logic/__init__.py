"""Gates, delay lines and latches: what goes between a chip and its neighbours."""
