"""Time as a control: breakpoints, steps, and the way back to instants that were."""
