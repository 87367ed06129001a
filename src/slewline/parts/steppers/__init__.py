"""A stepper motor on a bench: inputs, motion (computed on demand), counts crossed by its shaft, lost steps."""
