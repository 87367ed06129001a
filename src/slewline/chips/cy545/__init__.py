"""The CY545 and CY545B: two ways in, a memory of its own, jogging and homing."""
