"""Sphinx's settings for the site; `scripts/docs` builds it, every warning an error."""

import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from docs.generate import interface, mathml, pages  # noqa: E402
from seat_gear_dynamics import __version__  # noqa: E402

project = "seat_gear_dynamics"
author = "the seat_gear_dynamics developers"
version = release = __version__
language = "en"

extensions = ["myst_parser", "sphinx.ext.autodoc", pages.__name__, interface.__name__, mathml.__name__]
source_suffix = {".md": "markdown"}
exclude_patterns = ["generate"]
nitpicky = True

myst_enable_extensions = ["dollarmath", "deflist"]
myst_heading_anchors = 4

autodoc_typehints = "none"
autodoc_member_order = "bysource"

html_theme = "furo"
html_title = "Seat gear dynamics"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_math_renderer = "mathml"
html_copy_source = False
html_show_sourcelink = False
html_show_copyright = False
pygments_style = "friendly"
pygments_dark_style = "monokai"
