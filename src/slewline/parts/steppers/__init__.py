"""A stepper motor on a bench: its inputs, its run made on demand, what its shaft passes, the steps that it loses."""
