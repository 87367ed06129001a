"""Checks of STEP and DIR recordings against the data sheets of the receiving driver and the sending part.

The measurements are in `record/measuring`; `checking.py` defines the checks, `capture_report.py` shows the results.
"""
