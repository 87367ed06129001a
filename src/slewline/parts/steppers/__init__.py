"""A stepper motor on a bench: its inputs, its run (computed on demand), passings of its shaft, and lost steps."""
