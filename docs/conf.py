"""How Sphinx makes the site: `make docs`. Nothing is loaded from elsewhere: no fonts, scripts or search service."""

from __future__ import annotations

import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

import conicoid  # noqa: E402
from docs.tools import docstrings, mathml, pages  # noqa: E402

project = "Conicoid"
author = "Conicoid developers"
copyright = "Conicoid developers, MIT licence"  # noqa: A001  (Sphinx chose the name)
version = release = conicoid.__version__

extensions = ["myst_parser", "sphinx.ext.autodoc"]
exclude_patterns = ["tools"]
myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 4

autodoc_member_order = "bysource"
autodoc_typehints = "none"  # types stand in the docstrings, in words
python_maximum_signature_line_length = 100
add_module_names = False
default_role = "code"

html_theme = "furo"
html_title = "Conicoid"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_extra_path = ["../out/extra"]  # the live pages of the gallery and the example programs: docs/tools/live.py
html_copy_source = False
html_show_sphinx = False
html_math_renderer = "mathml"
html_last_updated_fmt = None
html_theme_options = {
    "light_css_variables": {"color-brand-primary": "#8a4b1f", "color-brand-content": "#8a4b1f"},
    "dark_css_variables": {"color-brand-primary": "#e0a878", "color-brand-content": "#e0a878"},
}


def setup(app):  # type: ignore[no-untyped-def]
    """What Sphinx calls before it reads anything."""
    mathml.connect(app)
    app.connect("autodoc-process-docstring", docstrings.process)
    app.connect("autodoc-process-signature", docstrings.signature)
    app.connect("source-read", pages.process)
