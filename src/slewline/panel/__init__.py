"""Front ends that show a running bench through its control port: the panel, a web page; in `terminal/`, the debugger.

`web_server.py` has the web server, `guard.py` refuses requests from the pages of other sites, `relay.py` connects a
page to the control port; the page itself is in `page/`.  `python -m slewline.panel --attach HOST:PORT` runs the panel
as a separate process, so that it never delays a chip.  Drawing is done here; the data comes from links/views.
"""
