"""The reference of the package, from its docstrings: one page per class. Built by `cargo xtask docs`."""

from importlib.metadata import version as version_of
from pathlib import Path

project = "narx"
version = release = version_of("narx")
extensions = ["sphinx.ext.autodoc", "sphinx.ext.autosummary"]
# Absolute, because a relative path would be taken from the folder of the pages.
templates_path = [str(Path(__file__).parent / "templates")]
# Names in `__all__` are public, wherever they are defined.
autosummary_imported_members = True
autosummary_ignore_module_all = False
autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_preserve_defaults = True
# Docstrings are plain text; text in single backticks is code.
default_role = "code"
html_theme = "alabaster"
html_theme_options = {"description": "The narx drive for BLDC motors", "page_width": "70em"}
html_show_sourcelink = False
html_copy_source = False
