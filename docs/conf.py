"""Sphinx: `make docs`.  Nothing from outside is fetched, neither here nor by the pages."""

import sys
from pathlib import Path

import slewline

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE / "_extensions"))
LIGHT, DARK = "#0a7567", "#41c7b4"  # the accent of the panel, on light and on dark ground

project = "slewline"
copyright = "slewline contributors"
version = release = slewline.__version__
extensions = [
    "myst_nb",  # myst_parser, and notebooks
    "sphinx.ext.autodoc",
    "sphinx_copybutton",
    "sphinx_design",
    # those of docs/_extensions
    "by_hand",
    "names",
    "search_words",
    "sources",
]
nb_execution_mode = "force"  # the lessons are kept without outputs
nb_execution_in_temp = True
nb_execution_raise_on_error = True
nb_execution_timeout = 120  # seconds, a cell
nb_merge_streams = True
nb_code_prompt_show = nb_code_prompt_hide = "Solution"  # of a cell that is folded
smartquotes = False  # an option has two hyphens, and text in quotation marks may be typed
myst_enable_extensions = ["colon_fence"]
myst_heading_anchors = 3
html_theme = "furo"
html_title = "slewline"
html_favicon = "../src/slewline/panel/page/icon.svg"
html_copy_source = html_show_sourcelink = False
html_search_scorer = str(HERE / "search.js")
html_static_path = ["_static"]
html_css_files = ["wide.css", "index.css", "pictures.css", "api.css", "lessons.css"]
html_theme_options = {
    "top_of_page_buttons": [],
    "light_css_variables": {"color-brand-primary": LIGHT, "color-brand-content": LIGHT, "color-brand-visited": LIGHT},
    "dark_css_variables": {"color-brand-primary": DARK, "color-brand-content": DARK, "color-brand-visited": DARK},
}
pygments_style, pygments_dark_style = "tango", "github-dark"
copybutton_prompt_text = r"\$ |PS> |>>> |\.\.\. "  # what a reader types is copied, without the prompt
copybutton_prompt_is_regexp = True

# --------------------------------------------------------------------------------- the API, from the docstrings
default_role = "py:obj"  # `name` in a docstring: a link where it is a name of ours, else code
add_module_names = False
autodoc_member_order = "bysource"
autodoc_type_aliases = {"Time": "Time"}
python_use_unqualified_type_names = True
python_display_short_literal_types = True
maximum_signature_line_length = 80
toc_object_entries_show_parents = "hide"
