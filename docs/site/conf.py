"""The documentation site: guide, protocol, evidence, and the Python reference with its notebooks. Built by `cargo xtask site`."""

import os
import sys
from pathlib import Path

root = Path(os.environ["NARX_ROOT"])
sys.path.insert(0, str(root / "python/docs"))
from conf import *  # noqa: E402, F403 (the reference's own settings)

extensions = [*extensions, "myst_nb"]  # noqa: F405
templates_path = [str(root / "docs/site/templates"), str(root / "python/docs/templates")]
source_suffix = {".rst": "restructuredtext", ".md": "myst-nb", ".ipynb": "myst-nb"}
# Everything else in the tree is what pages link to: such a file is copied.
include_patterns = [
    "*.md", "docs/**", "python/*.md", "python/*.rst", "python/api/**", "python/notebooks/**", "board/*.md", "ffi/*.md",
    "examples/**", "tests/*.md",
]
exclude_patterns = ["docs/site"]
# Links are to headings of other pages, as on a host of repositories.
myst_heading_anchors = 4
myst_enable_extensions = ["deflist"]
# The notebooks run when the site is built, so that what is shown is this version's.
nb_execution_mode = os.environ.get("NARX_NOTEBOOKS", "force")
nb_execution_timeout = 600
nb_execution_raise_on_error = True
html_theme = "furo"
html_theme_options = {}
html_title = f"narx {release}"  # noqa: F405
# A block for Rust that is no whole program.
suppress_warnings = ["misc.highlighting_failure"]
