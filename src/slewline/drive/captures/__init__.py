"""Recordings of STEP and DIR against the data sheets of the driver that receives them and the part that makes them.

What is measured is in `record/measuring`; `checking.py` names what is checked, `capture_report.py` shows it.
"""
