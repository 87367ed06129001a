"""Sphinx: `make docs`.  Nothing from outside is fetched, neither here nor by the pages."""

import sys
from pathlib import Path

import slewline

project = "slewline"
copyright = "slewline contributors"
version = release = slewline.__version__
extensions = ["myst_parser"]
smartquotes = False  # an option has two hyphens, and text in quotation marks may be typed
myst_heading_anchors = 3
html_theme = "furo"
html_title = "slewline"
html_copy_source = html_show_sourcelink = False
html_static_path = ["_static"]
html_css_files = ["index.css", "pictures.css", "tables.css"]
html_theme_options = {"top_of_page_buttons": []}
pygments_style = "tango"


def setup(app):
    """Leave the pages for contributors out of the full text search: who looks for a ramp does not want a decision."""
    app.connect("env-updated", leave_out)


def leave_out(_app, env):
    for page in env.found_docs:
        if page.startswith(("decisions/", "reference/conformance")):
            env.metadata[page]["no-search"] = True


# --------------------------------------------------------------------------------- the API, from the docstrings
sys.path.insert(0, str(Path(__file__).with_name("_extensions")))
extensions += ["sphinx.ext.autodoc", "names", "sources"]
html_css_files += ["api.css"]
default_role = "py:obj"  # `name` in a docstring: a link where it is a name of ours, else code
add_module_names = False
autodoc_member_order = "bysource"
autodoc_preserve_defaults = True
autodoc_type_aliases = {"Time": "Time"}
python_use_unqualified_type_names = True
python_display_short_literal_types = True
maximum_signature_line_length = 80
toc_object_entries_show_parents = "hide"
