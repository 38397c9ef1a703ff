"""Settings of Sphinx for the documentation site; `build.py` lays out the pages that it reads."""

project = "Campusloop"
html_title = "Campusloop"
extensions = ["myst_parser"]
html_theme = "furo"
# Links to headings are checked down to this depth.
myst_heading_anchors = 4
html_copy_source = False
html_show_copyright = False
