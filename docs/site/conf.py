# The site that ./dev docs builds: README, docs/, the C++ API from its header's comments, the Python package from its
# docstrings. Whatever does not resolve is an error.
import os

project = "Latelight"
author = "the authors of Latelight"
html_title = "Latelight"
html_theme = "furo"
html_show_copyright = False
html_copy_source = False
html_show_search_summary = False  # which would be fetched: a browser refuses that for files
html_extra_path = ["index.html"]

extensions = ["myst_parser", "breathe", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
root_doc = "docs/site/index"
include_patterns = ["*.md", "docs/**"]
exclude_patterns = ["docs/images/**"]

myst_heading_anchors = 4
breathe_projects = {"latelight": os.environ["LATELIGHT_DOXYGEN"]}
breathe_default_project = "latelight"
autodoc_member_order = "bysource"
autodoc_default_options = {"members": True, "imported-members": True, "undoc-members": True}
