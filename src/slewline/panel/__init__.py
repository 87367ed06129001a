"""Front ends that show a bench while it runs, over its control port: the panel, a web page, and `terminal/`.

`web_server.py` has the web server, `guard.py` what keeps strangers out, `relay.py` the way between a page and the
control port; the page itself is in `page/`.  `python -m slewline.panel --attach HOST:PORT` runs it as a process of its
own, so that it never delays a chip.  What is drawn is here, the data behind it in links/views.
"""
