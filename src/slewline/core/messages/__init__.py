"""What messages to users are made of: names that were meant, calls that do not fit, what to write instead."""
