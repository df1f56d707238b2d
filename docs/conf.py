"""How Sphinx makes the site: `make site`. The pages are the Markdown files as they stand, so links work in both places.

The source folder is the checkout itself, because README.md, CONTRIBUTING.md and the notebooks of examples/ are pages
too, and what a page links to by its path has to be found by that path here as on a forge.
"""

from __future__ import annotations

import sys
from pathlib import Path

sys.path[:0] = [str(Path(__file__).parent), str(Path(__file__).parent.parent)]

from site_building import setup  # noqa: E402, F401  (Sphinx calls it)

project = "asmc_pin"
author = copyright = "The asmc_pin developers"
html_title = "asmc_pin"

extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
root_doc = "docs/index"
include_patterns = ["*.md", "docs/*.md", "docs/*/*.md", "docs/api/*.rst", "benchmarks/README.md", "examples/*.ipynb"]
exclude_patterns = [".*", "*/.*", "asmc_pin", "build", "dist", "results", "tests", "urdf", "viz"]

# A picture with a width, as a forge takes it.
myst_enable_extensions = ["html_image"]
# Headings get the anchors that a forge gives them.
myst_heading_anchors = 4
# Notebooks are shown as they were committed; a test runs them.
nb_execution_mode = "off"

# A signature says the types; what a docstring says of its arguments stands below it.
autodoc_typehints = "signature"
autodoc_member_order = "bysource"
autodoc_default_options = {"members": True}
default_role = "code"
napoleon_google_docstring = True
napoleon_numpy_docstring = False
napoleon_use_ivar = True

# A link that leads nowhere is an error; the types in signatures are often other projects', or not public.
nitpicky = True
nitpick_ignore_regex = [("py:(class|exc)", ".*")]

html_theme = "furo"
html_theme_options = {"source_edit_link": ""}
html_show_sourcelink = False
html_copy_source = False
