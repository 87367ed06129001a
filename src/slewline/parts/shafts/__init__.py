"""What turns, and what sits on it: motors, shafts, gears and carriages, encoders and switches."""
