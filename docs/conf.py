"""Sphinx: `make docs`.  Nothing from outside is fetched, neither here nor by the pages."""

import slewline

project = "slewline"
copyright = "slewline contributors"
version = release = slewline.__version__
extensions = ["myst_nb"]  # myst_parser, and notebooks
nb_execution_mode = "force"  # the lessons are kept without outputs
nb_execution_in_temp = True
nb_execution_raise_on_error = True
nb_execution_timeout = 120  # seconds, a cell
nb_merge_streams = True
nb_code_prompt_show = nb_code_prompt_hide = "Solution"  # of a cell that is folded
smartquotes = False  # an option has two hyphens, and text in quotation marks may be typed
myst_heading_anchors = 3
html_theme = "furo"
html_title = "slewline"
html_copy_source = html_show_sourcelink = False
html_static_path = ["_static"]
html_css_files = ["index.css", "lessons.css", "pictures.css", "tables.css"]
html_theme_options = {"top_of_page_buttons": []}
pygments_style = "tango"


def setup(app):
    """Leave the pages for contributors out of the full text search: who looks for a ramp does not want a decision."""
    app.connect("env-updated", leave_out)


def leave_out(_app, env):
    for page in env.found_docs:
        if page.startswith(("decisions/", "reference/conformance")):
            env.metadata[page]["no-search"] = True
