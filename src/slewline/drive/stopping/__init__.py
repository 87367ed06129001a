"""What happens when a board stops its motor by itself, and how the chip comes to stop where the motor has."""
