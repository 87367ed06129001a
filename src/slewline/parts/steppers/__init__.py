"""A stepper motor: its inputs, its motion (computed on demand), the counts of its shaft, and lost steps."""
