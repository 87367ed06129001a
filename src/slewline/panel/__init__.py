"""Front ends that show a running bench through its control port: the panel, which is a web page, and `terminal/`.

`web_server.py` has the web server, `guard.py` keeps foreign pages out, `relay.py` connects a page to the control port;
the page itself is in `page/`.  `python -m slewline.panel --attach HOST:PORT` runs the panel as a separate process, so
that it never delays a chip.  Drawing is done here; the data comes from links/views.
"""
