"""How the documentation is built: `make docs`, which treats a warning as an error and runs every example."""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import Any
from weakref import WeakSet

import matplotlib
from matplotlib.figure import Figure
from sphinx_gallery.scrapers import figure_rst

from springpot.machine.installed import __version__

project = "springpot"
author = "The springpot developers"
copyright = "the springpot developers"
release = version = __version__

extensions = [
    "myst_nb",
    "numpydoc",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.mathjax",
    "sphinx-mathjax-offline",
    "sphinx_gallery.gen_gallery",
    "sphinxcontrib.bibtex",
]
exclude_patterns = [
    "_build", "_jupyter", "gallery/**", "auto_gallery/**.ipynb", "auto_gallery/**.py", "**.ipynb_checkpoints",
    "sg_execution_times.rst",
]  # fmt: skip
templates_path = ["_templates"]
nitpicky = True
# prose of numpydoc's type lines and of single backticks is looked up, and left as it is where nothing has that name
default_role = "py:obj"
nitpick_ignore_regex = [("py:obj", r".*")]
suppress_warnings = ["config.cache"]  # functions in this file cannot be pickled, so that it is read anew each time

# --- pages ------------------------------------------------------------------------------------------------------------

html_theme = "pydata_sphinx_theme"
html_title = "springpot"
html_static_path = ["_static"]
html_css_files = ["springpot.css"]
html_sidebars: dict[str, list[str]] = {"questions": []}  # no pages are below it
html_show_sourcelink = False
html_copy_source = False
html_theme_options: dict[str, Any] = {
    "show_prev_next": True,
    "navigation_with_keys": True,
    "secondary_sidebar_items": ["page-toc"],
    "header_links_before_dropdown": 6,
    "footer_start": ["copyright"],
    "footer_end": [],
    "show_toc_level": 2,
    "pygments_light_style": "tango",
    "pygments_dark_style": "monokai",
}

mathjax_path = "mathjax/tex-chtml.js"  # a copy that comes along: the pages read well without a network
myst_enable_extensions = ["dollarmath", "amsmath", "colon_fence", "deflist"]
myst_heading_anchors = 3
myst_dmath_double_inline = True
nb_execution_mode = "force"  # a cache would not notice a change of the library
nb_execution_timeout = 180
nb_execution_raise_on_error = True
nb_execution_show_tb = True
nb_merge_streams = True
nb_render_markdown_format = "myst"

bibtex_bibfiles = ["references.bib"]
bibtex_reference_style = "author_year"

# --- reference --------------------------------------------------------------------------------------------------------

autosummary_generate = True
autosummary_imported_members = True
autodoc_typehints = "none"
autodoc_member_order = "bysource"
numpydoc_show_class_members = False
numpydoc_class_members_toctree = False

# --- gallery ----------------------------------------------------------------------------------------------------------


def plain_figures(gallery_conf: dict[str, Any], fname: str) -> None:
    """Every example begins with the library's look of a picture."""
    matplotlib.rcParams.update(
        {
            "axes.grid": True,
            "axes.axisbelow": True,
            "axes.spines.top": False,
            "axes.spines.right": False,
            "grid.color": "0.9",
            "grid.linewidth": 0.6,
            "figure.constrained_layout.use": True,
            "figure.dpi": 100,
        }
    )


drawn: WeakSet[Figure] = WeakSet()


def own_figures(block: Any, block_vars: dict[str, Any], gallery_conf: dict[str, Any]) -> str:
    """Show the figures that an example holds and pyplot does not know, such as those of ``sp.figures.draw_study``."""
    shown = []
    for value in block_vars["example_globals"].values():
        if isinstance(value, Figure) and value not in drawn:
            drawn.add(value)
            if value.canvas.manager is None:  # pyplot's are shown, and closed, by the scraper that comes next
                shown.append(next(block_vars["image_path_iterator"]))
                value.savefig(shown[-1], dpi=100)
    return figure_rst(shown, gallery_conf["src_dir"])


sphinx_gallery_conf: dict[str, Any] = {
    "examples_dirs": "gallery",
    "gallery_dirs": "auto_gallery",
    "filename_pattern": r"/plot_",
    "within_subsection_order": "FileNameSortKey",
    "reset_modules": ("matplotlib", plain_figures),
    "image_scrapers": (own_figures, "matplotlib"),
    "download_all_examples": False,
    "remove_config_comments": True,
    "show_signature": False,
    "min_reported_time": 1,
    "write_computation_times": False,  # that page takes its scripts from the network
    "capture_repr": (),
    "doc_module": ("springpot",),
    "backreferences_dir": "api/backreferences",
    "inspect_global_variables": False,
}


def to_built_gallery(app: Any, docname: str, source: list[str]) -> None:
    """Links to files of the gallery, which a reader of the repository can follow, lead to the pages made of them."""
    link = r"(?<=[(/])gallery/(?:README\.rst|(plot_\w+)\.py)(?=\))"
    source[0] = re.sub(link, lambda found: f"auto_gallery/{found[1] or 'index'}.rst", source[0])


def setup(app: Any) -> None:
    """What Sphinx calls first."""
    app.connect("source-read", to_built_gallery)


# the kernel that runs the pages, without its word of warning about the loopback network
os.environ["JUPYTER_PATH"] = str(Path(__file__).parent / "_jupyter")
