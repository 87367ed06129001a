"""The proof of a translation: source and result are run, and the events of both runs are compared.

play.py           runs a program on a bench with one of our parts; an input for which the part waits is changed
compare_runs.py   two traces: events in order, and times and rates within the report's bounds
picture.py        a picture of both runs, overlaid
prove.py          the whole proof, for our parts and for other targets
prove_bench.py    the whole proof for a bench with several chips
"""
