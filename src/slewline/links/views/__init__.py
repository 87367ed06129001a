"""What is seen of a server: its state, what is said, what signals did, findings on a terminal.

Here is the data that a page or a terminal shows, without the name of a part; of a part it is what its `shows()` fills
in.
"""
