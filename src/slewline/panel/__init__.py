"""Front ends that show a running bench: the panel (a web page) and the debugger (in `terminal/`).

Both use the control port of the bench.
`web_server.py` has the web server, `guard.py` refuses requests from the pages of other sites, `relay.py` connects a
page to the control port; the page itself is in `page/`.  `python -m slewline.panel --attach HOST:PORT` runs the panel
as a separate process, so that it never delays a chip.  Drawing is done here; the data comes from links/views.
"""
