"""The proof of a translation: source and result are run, and the events of both runs are compared.

play.py           runs a program with one of our parts; if the part waits for an input, changes it
compare_runs.py   compares two traces: the order of events; times and rates, within the report's bounds
picture.py        draws a picture of both runs, overlaid
prove.py          performs the whole proof, for our parts and for other targets
prove_bench.py    performs the whole proof for a bench with several chips
"""
