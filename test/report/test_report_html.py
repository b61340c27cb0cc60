"""Pieces of HTML: everything is escaped, and numbers stand where they belong."""

import base64
import re
from html.parser import HTMLParser

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lagrangian_ff.report import html

PICTURE = html.PNG + b"rest of the picture"
VOID = {"img", "input", "meta", "br"}


class Balance(HTMLParser):
    """Reads HTML and fails where a tag is closed that was not open."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.text: list[str] = []

    def handle_starttag(self, tag: str, attrs: object) -> None:
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.text.append(data)


def texts(piece: str) -> list[str]:
    """What a reader sees of it; fails where tags are not balanced."""
    reader = Balance()
    reader.feed(piece)
    reader.close()
    assert not reader.open
    return [text for text in reader.text if text.strip()]


words = st.text(st.characters(blacklist_categories=["Cs", "Cc"]), min_size=1).filter(str.strip)


@given(words)
def test_no_text_becomes_a_tag(text: str) -> None:
    for piece in (
        html.paragraph(text),
        html.note(text),
        html.steps([text]),
        html.table([text], [[text]]),
        html.cards([html.Card(text, text, text, good=True)]),
        html.figure(PICTURE, text, text),
        html.bullets([text]),
        html.badge(text, text),
        html.shares([html.Share(text, text, ((text, 0.5),))]),
        html.tabs(text, [(text, html.note(text))]),
        html.plots([html.note(text)]),
    ):
        assert set(texts(piece)) == {text}


def test_a_table_needs_rows_as_long_as_its_header() -> None:
    with pytest.raises(ValueError, match="2 texts under 1 headings"):
        html.table(["joint"], [["elbow", "1"]])


def test_words_are_left_and_the_column_that_matters_is_strong() -> None:
    piece = html.table(["joint", "a", "b"], [["elbow", "1", "2"]], strong=2)
    assert '<td class="word">elbow</td><td>1</td><td class="strong">2</td>' in piece


def test_a_picture_is_inside_the_page() -> None:
    found = re.search(r'src="data:image/png;base64,([^"]+)"', html.figure(PICTURE, "an arm"))
    assert found is not None
    assert base64.b64decode(found[1]) == PICTURE


def test_what_is_no_png_is_refused() -> None:
    with pytest.raises(ValueError, match="PNG"):
        html.figure(b"GIF89a", "a picture")


@pytest.mark.parametrize(
    ("good", "kind"), [(None, "card"), (True, "card good"), (False, "card bad")]
)
def test_a_card_shows_its_judgement(good: bool | None, kind: str) -> None:
    assert f'class="{kind}"' in html.cards([html.Card("3 ×", "better", good=good)])


def test_bars_are_as_long_as_the_shares_and_never_longer_than_the_row() -> None:
    parts = (("of its error", 0.41), ("too much", 1.7), ("too little", -0.1))
    piece = html.shares([html.Share("joint_2", "slow", parts)])
    assert re.findall(r'width:([\d.]+)%"', piece) == ["41.0", "100.0", "0.0"]


def test_one_panel_of_tabs_is_chosen_at_first() -> None:
    piece = html.tabs("joints", [("a", ""), ("b", ""), ("c", "")], first=1)
    chosen = re.findall(r'id="([^"]+)"( checked)?', piece)
    assert chosen == [("joints-0", ""), ("joints-1", " checked"), ("joints-2", "")]
    assert re.findall(r'for="([^"]+)"', piece) == [mark for mark, _ in chosen]
