"""Motors that lose steps: a motor, its driver and its load, as equations that are integrated behind a shaft."""
