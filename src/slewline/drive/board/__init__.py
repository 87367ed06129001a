"""The board: what host and board say to each other, its clock, its port, and a twin of it in software."""
