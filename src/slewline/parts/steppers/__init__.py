"""A stepper motor: inputs, motion (computed on demand), the counts that its shaft crosses, and lost steps."""
