"""The proof of a translation: source and result are run, and what they did is compared with what the report states.

play.py      one of our parts runs a text on a bench; its inputs change when it waits for one
compare.py   two traces: moves, directions, outputs and inputs in their order, times and rates within the report
picture.py   both over each other
prove.py     all of it, for our parts and for other targets
"""
