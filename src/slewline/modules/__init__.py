"""Real modules on a serial port: their dialogues, their backups, and how they differ from the model."""
