"""Small pieces of HTML; every text is escaped here and nowhere else."""

import base64
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from html import escape

PNG = b"\x89PNG\r\n\x1a\n"


@dataclass(frozen=True)
class Card:
    """One finding to be read from afar.

    Attributes:
        value: the number, with its unit.
        label: what it is.
        detail: against what it is measured.
        good: whether it is as it should be; None if there is nothing to judge.
    """

    value: str
    label: str
    detail: str = ""
    good: bool | None = None


@dataclass(frozen=True)
class Share:
    """A place, and how much of two wholes lies there.

    Attributes:
        name: of what it belongs to, set in bold.
        text: the place.
        parts: label and share (0 to 1) of each bar; the first is the one that matters.
    """

    name: str
    text: str
    parts: Sequence[tuple[str, float]]


def paragraph(text: str) -> str:
    """Return running text."""
    return f"<p>{escape(text)}</p>"


def note(text: str) -> str:
    """Return small print."""
    return f'<p class="note">{escape(text)}</p>'


def steps(texts: Iterable[str]) -> str:
    """Return a numbered list."""
    return f"<ol>{''.join(f'<li>{escape(text)}</li>' for text in texts)}</ol>"


def bullets(texts: Iterable[str]) -> str:
    """Return a list without numbers."""
    return f"<ul>{''.join(f'<li>{escape(text)}</li>' for text in texts)}</ul>"


def badge(text: str, kind: str = "") -> str:
    """Return a word in a frame whose colour is that of the kind: `good`, `fair`, `bad` or none."""
    return f'<span class="badge {escape(kind)}">{escape(text)}</span>'


def shares(rows: Iterable[Share]) -> str:
    """Return places with their shares as bars, one under the other."""
    return f'<div class="shares">{"".join(map(_share, rows))}</div>'


def _share(row: Share) -> str:
    bars = "".join(
        f'<div class="bar"><i style="width:{100.0 * min(1.0, max(0.0, share)):.1f}%"></i></div>'
        f"<span>{escape(label)}</span>"
        for label, share in row.parts
    )
    return (
        f'<div class="share"><p><b>{escape(row.name)}</b> <span>{escape(row.text)}</span></p>'
        f'<div class="bars">{bars}</div></div>'
    )


def plots(pieces: Iterable[str]) -> str:
    """Return small figures in columns, as many as there is room for."""
    return f'<div class="plots">{"".join(pieces)}</div>'


def tabs(name: str, panels: Sequence[tuple[str, str]], first: int = 0) -> str:
    """Return pieces of HTML of which one is shown; choosing it needs no script.

    Args:
        name: differs from that of all other tabs of the page.
        panels: label and HTML of each.
        first: the one shown before any choice.
    """
    parts = []
    for k, (label, body) in enumerate(panels):
        mark = f"{escape(name)}-{k}"
        checked = " checked" if k == first else ""
        parts.append(
            f'<input type="radio" name="{escape(name)}" id="{mark}"{checked}>'
            f'<label for="{mark}">{escape(label)}</label>'
            f'<div class="panel"><h3 class="label">{escape(label)}</h3>{body}</div>'
        )
    return f'<div class="tabs">{"".join(parts)}</div>'


def beside(left: str, right: str) -> str:
    """Return two pieces of HTML side by side if there is room."""
    return f'<div class="beside"><div>{left}</div><div>{right}</div></div>'


def columns(pieces: Iterable[str]) -> str:
    """Return pieces of HTML in columns of one width, as many as there is room for."""
    return f'<div class="columns">{"".join(f"<div>{piece}</div>" for piece in pieces)}</div>'


def cards(found: Iterable[Card]) -> str:
    """Return findings side by side."""
    return f'<div class="cards">{"".join(map(_card, found))}</div>'


def _card(card: Card) -> str:
    kind = {None: "", True: " good", False: " bad"}[card.good]
    detail = f"<small>{escape(card.detail)}</small>" if card.detail else ""
    return (
        f'<div class="card{kind}"><b>{escape(card.value)}</b>'
        f"<span>{escape(card.label)}</span>{detail}</div>"
    )


def figure(picture: bytes, alternative: str, caption: str = "") -> str:
    """Return a PNG inside the page, with an alternative for readers who cannot see it.

    Raises:
        ValueError: not a PNG.
    """
    if not picture.startswith(PNG):
        raise ValueError("expected the bytes of a PNG file")
    data = base64.b64encode(picture).decode("ascii")
    below = f"<figcaption>{escape(caption)}</figcaption>" if caption else ""
    image = f'<img alt="{escape(alternative)}" src="data:image/png;base64,{data}">'
    return f"<figure>{image}{below}</figure>"


def table(
    header: Sequence[str],
    rows: Sequence[Sequence[str]],
    *,
    words: int = 1,
    strong: int | None = None,
    total: bool = False,
) -> str:
    """Return a table whose first columns are words and whose others are numbers.

    Args:
        header, rows: one text a column each.
        words: how many columns, from the left, hold words.
        strong: the column that matters most.
        total: whether the last row sums up the others.

    Raises:
        ValueError: a row that is not as long as the header.
    """
    lines = [_row(header, "th", words, strong)]
    for row in rows:
        if len(row) != len(header):
            raise ValueError(f"a row of {len(row)} texts under {len(header)} headings: {row}")
        lines.append(_row(row, "td", words, strong))
    kind = ' class="total"' if total else ""
    body = f"<thead>{lines[0]}</thead><tbody>{''.join(lines[1:])}</tbody>"
    return f'<div class="wide"><table{kind}>{body}</table></div>'


def _row(texts: Sequence[str], tag: str, words: int, strong: int | None) -> str:
    cells = []
    for column, text in enumerate(texts):
        kinds = ["word"] * (column < words) + ["strong"] * (column == strong)
        attribute = f' class="{" ".join(kinds)}"' if kinds else ""
        cells.append(f"<{tag}{attribute}>{escape(text)}</{tag}>")
    return f"<tr>{''.join(cells)}</tr>"
