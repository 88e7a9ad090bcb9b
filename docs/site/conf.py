"""Sphinx settings of the documentation's site."""

project = "Pelagos"
author = "the Pelagos authors"
copyright = "the Pelagos authors"
extensions = ["myst_parser", "sphinx_design", "sphinx-mathjax-offline", "sphinx.ext.mathjax"]
source_suffix = {".md": "markdown"}
root_doc = "index"
exclude_patterns = ["site"]
myst_enable_extensions = ["dollarmath", "colon_fence", "deflist", "attrs_block"]
myst_heading_anchors = 4
suppress_warnings = ["myst.header"]  # pages made of docstrings may skip a level
html_theme = "pydata_sphinx_theme"
html_title = "Pelagos"
html_static_path = ["_static"]
html_css_files = ["pelagos.css"]
html_theme_options = {
    "navigation_with_keys": True,
    "show_toc_level": 2,
    "navbar_align": "left",
    "header_links_before_dropdown": 7,
    "secondary_sidebar_items": ["page-toc"],
    "footer_start": ["copyright"],
    "footer_end": [],
    "pygments_light_style": "tango",
    "pygments_dark_style": "monokai",
}
html_show_sphinx = False
html_copy_source = False
html_use_index = False
html_show_sourcelink = False
templates_path = []
