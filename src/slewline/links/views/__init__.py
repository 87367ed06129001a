"""What is seen of a server: its state, what is said, what signals did, findings on a terminal."""
