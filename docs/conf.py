"""The documentation site: `python3 run.py docs` builds it into build/docs, without any network."""

import re
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent), str(HERE.parent / "workflow" / "lib")]

import generated  # noqa: E402 - lies beside this file

import roughcontact  # noqa: E402 - of this checkout, not another one that is installed

project = "roughcontact"
author = "The roughcontact maintainers"
copyright = author
version = release = roughcontact.__version__

extensions = [
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.viewcode",
    "numpydoc",
    "myst_nb",  # Markdown, and pages that are notebooks
]
exclude_patterns = ["generated"]  # included by other pages
nitpicky = True
default_role = "code"

# Markdown
myst_heading_anchors = 3
myst_enable_extensions = ["colon_fence", "deflist"]

# notebooks are run anew by every build, and one that fails is an error
nb_execution_mode = "force"
nb_execution_raise_on_error = True
nb_execution_timeout = 300

# docstrings
autosummary_generate = False
autodoc_typehints = "none"  # the sections Parameters and Returns say it with units
autodoc_member_order = "bysource"
numpydoc_show_class_members = False
numpydoc_xref_param_type = False

# pages
html_theme = "furo"
html_title = "roughcontact"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_show_sphinx = False
html_copy_source = False
html_theme_options = {
    "light_css_variables": {"color-brand-primary": "#00519e", "color-brand-content": "#00519e"},
    "dark_css_variables": {"color-brand-primary": "#7ab8f0", "color-brand-content": "#7ab8f0"},
}

generated.write(HERE / "generated", HERE / "reference")


def escape_bars(app, what, name, obj, options, lines):
    """Let |q| in a docstring be what it is in mathematics; reStructuredText takes it for a substitution."""
    literal = None  # indentation of the line that announced a literal block
    for number, line in enumerate(lines):
        indent = len(line) - len(line.lstrip())
        if literal is not None and line.strip() and indent <= literal:
            literal = None
        if literal is None and not line.lstrip().startswith((">>>", "...")):
            pieces = re.split(r"(`+[^`]+`+)", line)
            pieces[::2] = [re.sub(r"(?<!\\)\|", r"\\|", piece) for piece in pieces[::2]]
            lines[number] = "".join(pieces)
        if line.rstrip().endswith("::"):
            literal = indent


def rubrics_in_modules(app, what, name, obj, options, lines):
    """Make rubrics of the headings in a docstring of a module: numpydoc does not, and modules share pages."""
    if what == "module":
        text = re.sub(r"^(\w+)\n-+$", r".. rubric:: \1\n", "\n".join(lines), flags=re.MULTILINE)
        lines[:] = text.split("\n")


def setup(app):
    for change in (escape_bars, rubrics_in_modules):
        app.connect("autodoc-process-docstring", change, priority=100)  # before numpydoc rearranges them
