"""How Sphinx builds this folder into a site: `make docs`, without network, warnings are errors."""

from __future__ import annotations

import sys
from importlib.metadata import version as installed
from pathlib import Path
from typing import Generic, TypeVar

import numpy.typing
from sphinx.ext.napoleon import GoogleDocstring

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE / "extensions"))

# What NumPy makes of these two fills lines; here they are shown by the names people know.
Number = TypeVar("Number")


class ArrayLike:
    """Whatever NumPy makes an array of."""


class NDArray(Generic[Number]):
    """An array of numbers of one kind."""


for shown in (ArrayLike, NDArray):
    shown.__module__ = "numpy.typing"
    setattr(numpy.typing, shown.__name__, shown)

# A property is described by one phrase, often with a colon; it is not "type: description".
GoogleDocstring._consume_inline_attribute = lambda text: ("", text._consume_to_end())  # type: ignore[method-assign]

project = "elastomorph"
author = "the elastomorph contributors"
project_copyright = "the elastomorph contributors, MIT licence"
release = version = installed("elastomorph")

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "mathml", "verbs"]
exclude_patterns = ["extensions"]
language = "en"
# Nothing is fetched: a page of another project is a plain link.
nitpicky = False

# Anchors are those a code host makes from headings, so that one link serves both.
myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 4
myst_links_external_new_tab = False

autodoc_default_options = {"members": True, "member-order": "bysource"}
autodoc_typehints = "signature"
autodoc_typehints_format = "short"
autodoc_preserve_defaults = True
autodoc_mock_imports = ["torch"]
python_use_unqualified_type_names = True
python_maximum_signature_line_length = 88
napoleon_google_docstring = True
napoleon_numpy_docstring = False
napoleon_use_ivar = True
napoleon_use_rtype = False

html_theme = "furo"
html_math_renderer = "mathml"
html_title = f"elastomorph {release}"
html_copy_source = False
html_show_sourcelink = False
html_static_path = ["static"]
html_css_files = ["site.css"]
html_js_files = ["reach.js"]
html_theme_options = {"navigation_with_keys": True}
pygments_style = "a11y-high-contrast-light"
pygments_dark_style = "monokai"
