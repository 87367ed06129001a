"""The CY545 and CY545B: two host interfaces, a memory of their own, jogging and homing."""
