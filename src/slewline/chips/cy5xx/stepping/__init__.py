"""What turns the motor: how a plan is played, ramps by slope or by unit of time, outputs, twin."""
