"""How Sphinx builds the site: `make docs`, into out/docs."""

import re
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent
sys.path[:0] = [str(ROOT), str(ROOT / "tools")]

import reference  # noqa: E402
from sphinx.application import Sphinx  # noqa: E402

import lagrangian_ff  # noqa: E402

project = "lagrangian_ff"
release = version = lagrangian_ff.__version__
copyright = "lagrangian_ff maintainers, Apache-2.0"
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
exclude_patterns = ["Thumbs.db"]

myst_enable_extensions = ["attrs_inline", "deflist"]
myst_heading_anchors = 4
suppress_warnings = ["misc.highlighting_failure"]  # outputs with … are no JSON
highlight_language = "text"
smartquotes = False  # would make a dash of the -- of options

default_role = "code"  # `q` in a docstring is code
autodoc_typehints = "none"  # the signature has them
autodoc_typehints_format = "short"
autodoc_member_order = "bysource"
autodoc_inherit_docstrings = False
napoleon_use_rtype = False
napoleon_use_param = False
napoleon_use_ivar = True
nitpick_ignore_regex = [
    ("py:class", r"(numpy|collections|pathlib)\..*"),  # have no page here
    ("py:class", r"lagrangian_ff\..*"),  # of inner rooms
    ("py:class", r"[^.]*"),  # units and words that stand where Napoleon expects a type
    ("py:exc", r"\w+Error"),
]

html_theme = "furo"
html_title = f"lagrangian_ff {release}"
html_static_path = ["static"]
html_css_files = ["site.css"]
html_theme_options = {"navigation_with_keys": True}
html_show_sphinx = False
html_copy_source = False

PICTURE = re.compile(
    r'<picture>\s*<source[^>]*srcset="(?P<dark>[^"]+)">\s*'
    r'<img[^>]*?alt="(?P<alt>[^"]*)"[^>]*?src="(?P<light>[^"]+)"[^>]*>\s*</picture>'
)


def of_the_site(text: str) -> str:
    """Return the text of README.md with links and pictures as the site has them."""
    text = PICTURE.sub(
        r"![\g<alt>](\g<light>){.only-light}\n![\g<alt>](\g<dark>){.only-dark}", text
    )
    text = re.sub(r"\]\((?!https?:|#|docs/)", "](../", text)
    return text.replace("](docs/", "](").replace("](../CHANGELOG.rst", "](changelog.rst")


def read(app: Sphinx, page: str, source: list[str]) -> None:
    """Put README.md at the head of the first page, and let links to it lead there."""
    if page == "index":
        app.env.note_dependency(str(ROOT / "README.md"))
        source[0] = of_the_site((ROOT / "README.md").read_text(encoding="utf-8")) + source[0]
    source[0] = source[0].replace("](../README.md", "](index.md")


def rejoin(
    app: object, what: str, name: str, thing: object, options: object, lines: list[str]
) -> None:
    """Undo what Napoleon makes of `words: more words` of a property: a type and a description."""
    if what == "property" and lines and lines[-1].startswith(":type: "):
        lines[0] = f"{lines.pop().removeprefix(':type: ')}: {lines[0]}"


def setup(app: Sphinx) -> None:
    """Write the pages that follow from the program, and read README.md in."""
    reference.write(HERE / "reference")
    app.connect("source-read", read)
    app.connect("autodoc-process-docstring", rejoin, priority=900)
