"""Sphinx: `make docs`.  Nothing from outside is fetched, neither here nor by the pages."""

import slewline

project = "slewline"
copyright = "slewline contributors"
version = release = slewline.__version__
extensions = ["myst_parser"]
myst_heading_anchors = 3
html_theme = "furo"
html_title = "slewline"
html_copy_source = html_show_sourcelink = False
html_static_path = ["_static"]
html_css_files = ["pictures.css"]
html_theme_options = {"top_of_page_buttons": []}
pygments_style = "tango"
