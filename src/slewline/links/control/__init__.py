"""The control port and its requests.

Each kind of request, or verb, has a row, with its keys and those of its reply, and a method do_VERB:

    rows_of_pins.py, pin_verbs.py    pins, faults, the state of a server
    rows_of_views.py, view_verbs.py  views of chips and parts; events that a client subscribes to
    rows_of_time.py, time_verbs.py   pause, steps, breakpoints, going back to the past

The schema and its documentation page are generated from the rows (`tools/describe_docs.py`).
"""
