"""The proof of a translation: source and result are run, and their events are compared with the report.

play.py      one of our parts runs a text on a bench; its inputs change when it waits for one
compare.py   two traces: moves, directions, outputs and inputs in their order, times and rates within the report
picture.py   a picture of both, overlaid
prove.py     all of it, for our parts and for other targets
"""
