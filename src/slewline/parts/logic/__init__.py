"""Gates, delay lines and latches: what stands between a chip and its neighbours."""
