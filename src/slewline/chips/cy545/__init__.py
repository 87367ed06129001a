"""The CY545 and CY545B: chips with two host interfaces, their own external memory, jogging and homing."""
