"""A part of a page."""

from dataclasses import dataclass


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
