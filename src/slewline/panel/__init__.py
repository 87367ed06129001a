"""The panel: a web page on which a chip is seen and worked, over the control port of a server.

`app.py` has the web server, `guard.py` what keeps strangers out, `relay.py` the way between a page and the control
port; the page itself is in `page/`.  `python -m slewline.panel --attach HOST:PORT` runs it as a process of its own, so
that it never delays a chip.
"""
