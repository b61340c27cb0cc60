"""One file that shows everything and needs nothing else."""

from collections.abc import Sequence
from dataclasses import dataclass
from importlib.resources import files
from os import PathLike
from pathlib import Path

from lagrangian_ff.files import whole
from lagrangian_ff.report.html import escape
from lagrangian_ff.report.plot import MARK, scripts

NO_SCRIPT = (
    "<noscript><p>The figures of this page are drawn by JavaScript, which is switched off here. "
    "Everything they need is inside the page.</p></noscript>\n"
)


@dataclass(frozen=True)
class Section:
    """A heading, what to know before looking, and what there is to see.

    Attributes:
        title: the heading.
        lead: one or two sentences under it: what is seen and how it is read; plain text.
        body: HTML, complete in itself; made with `html`.
    """

    title: str
    lead: str
    body: str


def write_page(
    path: str | PathLike[str],
    title: str,
    sections: Sequence[Section],
    *,
    kicker: str = "",
    summary: str = "",
    footer: str = "",
) -> Path:
    """Write a page whose styles, pictures and scripts are inside it, and return its path.

    Args:
        path: the file to write, replaced when all of the page is there.
        title: the heading; say the verdict in it.
        sections: in the order they are shown.
        kicker: a line above the heading: what was done with what.
        summary: a few sentences under the heading.
        footer: small print at the end.

    Raises:
        OSError: the file cannot be written.
    """
    path = Path(path)
    style = files(__package__).joinpath("page.css").read_text(encoding="utf-8")
    above = f'<p class="kicker">{escape(kicker)}</p>' if kicker else ""
    below = f"<p>{escape(summary)}</p>" if summary else ""
    end = f"<footer>{escape(footer)}</footer>" if footer else ""
    interactive = any(MARK in section.body for section in sections)
    with whole(path) as made:
        made.write_text(
            '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
            '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
            f"<title>{escape(title)}</title>\n<style>\n{style}</style>\n</head>\n<body>\n<main>\n"
            f"<header>{above}<h1>{escape(title)}</h1>{below}</header>\n"
            f"{NO_SCRIPT if interactive else ''}{''.join(map(_html, sections))}{end}\n</main>\n"
            f"{scripts() if interactive else ''}</body>\n</html>\n",
            encoding="utf-8",
        )
    return path


def _html(section: Section) -> str:
    lead = f'<p class="lead">{escape(section.lead)}</p>' if section.lead else ""
    return f"<section>\n<h2>{escape(section.title)}</h2>\n{lead}\n{section.body}\n</section>\n"
