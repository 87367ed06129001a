"""A stepper motor on a bench: inputs, run (computed on demand), counts that its shaft passes, lost steps."""
