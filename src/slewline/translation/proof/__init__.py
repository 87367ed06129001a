"""The proof of a translation: source and result are run, and their events are compared with the report.

play.py      one of our parts runs a text on a bench; an input changes when the part waits for it
compare.py   two traces: moves, directions, outputs and inputs in order, times and rates within the report's bounds
picture.py   a picture of both runs, overlaid
prove.py     the whole proof, for our parts and for other targets
"""
