"""Commands about motors: which ramp holds, and what no data sheet says."""
