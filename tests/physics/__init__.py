"""What the physics of motors has to give, by number: `python -m tests.physics` or `make physics` prints the table.

Each row is a value from `MotorLaw`, beside the value that a closed form or a published curve expects, and a tolerance.
"""
