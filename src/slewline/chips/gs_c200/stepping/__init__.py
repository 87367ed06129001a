"""What turns the motor: how a plan is played, the position counter, the lines to the driver."""
