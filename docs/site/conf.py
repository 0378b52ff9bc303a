"""Configuration of the documentation site; `build.py` runs Sphinx with it."""

import sys
from pathlib import Path

from numpydoc.xref import DEFAULT_LINKS

import gearbow

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))  # gallery_figures.py, flowchart.py, index_entries.py, …

project = "gearbow"
author = "The gearbow maintainers"
project_copyright = author
version = release = gearbow.__version__
html_title = f"gearbow {release}"

extensions = [
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "numpydoc",
    "myst_nb",
    "sphinx_gallery.gen_gallery",
    "sphinx_copybutton",
    "flowchart",
    "numbers_in_tables",
    "index_entries",
]
exclude_patterns = [
    "examples/*.*",
    "examples/rotors",
    "gallery/**.ipynb",
    "gallery/**.py",
    "gallery/**.md5",
]
templates_path = [str(HERE / "templates")]
# The README, ARCHITECTURE.md and the pages of docs/ are read as GitHub shows them.
myst_heading_anchors = 4
myst_fence_as_directive = {"mermaid"}
highlight_language = "none"

# Notebooks have no stored outputs: the build runs them, and again only if a cell has changed.
nb_execution_mode = "cache"
nb_execution_raise_on_error = True
nb_execution_timeout = 120
nb_execution_in_temp = True

sphinx_gallery_conf = {
    "examples_dirs": [str(HERE.parents[1] / "examples" / "gallery")],
    "gallery_dirs": ["gallery"],
    "filename_pattern": r"\.py$",
    "within_subsection_order": "FileNameSortKey",
    "capture_repr": (),
    "image_scrapers": ("gallery_figures.scraper",),
    "reset_modules": (),
    "abort_on_example_error": True,
    "write_computation_times": False,  # they differ in every build
    "min_reported_time": 1e9,
    "show_memory": False,
    "show_signature": False,
    "download_all_examples": False,
    "copyfile_regex": r"$^",
    "thumbnail_size": (480, 320),
    "remove_config_comments": True,
}

# The docstrings give the types; signatures give names and defaults.
autodoc_typehints = "none"
autodoc_member_order = "bysource"
autodoc_class_signature = "mixed"
autosummary_generate = True
autosummary_ignore_module_all = False
numpydoc_show_class_members = False
numpydoc_class_members_toctree = False
# Public names in the types of parameters become links; links to other projects need a network.
numpydoc_xref_param_type = True
numpydoc_xref_aliases = {name: name for name in DEFAULT_LINKS}
numpydoc_xref_aliases |= {name: f"gearbow.results.{name}" for name in dir(gearbow.results)}
numpydoc_xref_aliases |= {name: f"gearbow.{name}" for name in dir(gearbow)}
numpydoc_xref_ignore = "all"
# Names in single backticks of docstrings become links where they are public.
default_role = "py:obj"

html_theme = "furo"
html_static_path = [str(HERE / "static")]
html_css_files = ["site.css"]
html_show_sphinx = False
html_copy_source = False
html_theme_options = {"navigation_with_keys": True}
