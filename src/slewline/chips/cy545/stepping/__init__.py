"""What turns the motor: motions, jog, HOME, and the outputs that it sees."""
