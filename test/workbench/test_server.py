"""The server against those who are not its page."""

import json
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from workbench_examples import Served, moved, serving

serve = pytest.fixture(serving)


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    for serve in serving():
        made = serve(tmp_path_factory.mktemp("server") / "session")
        yield made
        assert made.stop() == 0


def origin(served: Served) -> str:
    return served.address.rstrip("/")


def test_only_its_own_page_is_answered(served: Served) -> None:
    ours = origin(served)
    assert served.asked("")[0] == 200
    assert served.asked("", Host="example.org")[0] == 403
    assert served.asked("api/state", Origin="http://example.org")[0] == 403
    assert served.asked("api/state", Origin=ours)[0] == 200
    assert served.asked("api/ask/learn", b"{}")[0] == 403
    assert served.asked("api/ask/learn", b"{}", Origin="null")[0] == 403
    status, body = served.asked("api/ask/learn", b"{}", Origin=ours)
    assert status == 400
    assert "put a recording under Learn from" in json.loads(body)["error"]


@pytest.mark.parametrize(
    "path",
    ["page/../server.py", "page/..%2fserver.py", "page//etc/passwd", "api/take/..%2f..%2fx",
     "api/trace/m1?start=0&end=1&width=10", "api/take/m9"],
)  # fmt: skip
def test_no_file_outside_is_given(served: Served, path: str) -> None:
    status, body = served.asked(path)
    assert status in (400, 403, 404)
    assert b"import" not in body
    assert b"root:" not in body


@pytest.mark.parametrize(
    ("what", "body"),
    [("nonsense", b"{}"), ("role", b"{}"), ("role", b'{"card": "r9", "role": "learn"}'),
     ("add", b'{"effect": 3}'), ("undo", b"{}"), ("cancel", b'{"work": []}'), ("learn", b"[1]"),
     ("learn", b"{"), ("look", b'{"model": "m9"}')],
)  # fmt: skip
def test_questions_that_make_no_sense_are_mistakes_in_words(
    served: Served, what: str, body: bytes
) -> None:
    status, answer = served.asked(f"api/ask/{what}", body, Origin=origin(served))
    assert status in (200, 400)
    assert b"Traceback" not in answer
    assert served.asked("api/state")[0] == 200


@pytest.mark.parametrize(
    ("what", "body", "words"),
    [("learn", b"{}", "nothing to learn from: put a recording under Learn from"),
     ("diagnose", b"{}", "no model yet: learn one first"),
     ("whatif", b"{}", "no model yet: learn one first"),
     ("add", b'{"effect": "stribeck", "joint": "a"}', "no model yet: learn one first"),
     ("move", b'{"effect": "stribeck", "joint": "a"}', "no model yet: learn one first"),
     ("undo", b"{}", "no model yet: learn one first"),
     ("redo", b"{}", "nothing to do again"),
     ("remove", b'{"card": "r9"}', "this recording is no longer there; reload the page"),
     ("formula", b'{"name": "stribeck", "formula": "A*q", "shapes": {}}', "choose another name"),
     ("formula", b'{"name": "mine", "formula": "import os", "shapes": {}}', "mine"),
     ("formula", b'{"name": "mine", "formula": "A*q", "shapes": {"w": [1]}}', "unknown way"),
     ("nonsense", b"{}", "not known; reload it")],
)  # fmt: skip
def test_what_is_not_possible_now_is_said(
    served: Served, what: str, body: bytes, words: str
) -> None:
    status, answer = served.asked(f"api/ask/{what}", body, Origin=origin(served))
    assert status == 400
    assert words in json.loads(answer)["error"]


def test_the_name_of_an_upload_is_no_path(served: Served, tmp_path: Path) -> None:
    data = moved(tmp_path / "motion.npz", 0, seconds=12.0).read_bytes()
    name = "..%2F..%2F..%2Ftmp%2Fevil%0A.npz"
    status, answer = served.asked(f"api/upload?name={name}", data, Origin=origin(served))
    assert status == 200
    card = json.loads(answer)["card"]
    (file,) = (served.session / "recordings" / card).iterdir()
    assert file.name == "recording.npz"
    assert not list(served.session.glob(".upload-*"))


def test_others_than_this_machine_need_the_token(
    tmp_path: Path, serve: Callable[..., Served]
) -> None:
    served = serve(tmp_path / "session", "--host", "0.0.0.0")
    base, _, token = served.address.partition("?token=")
    port = base.rsplit(":", 1)[1]
    served.address = f"http://127.0.0.1:{port}"
    assert token
    assert served.asked("api/state")[0] == 401
    assert served.asked("api/state?token=wrong")[0] == 401
    assert served.asked(f"api/state?token={token}")[0] == 200
    assert served.stop() == 0


def test_a_taken_port_and_a_wrong_session_are_mistakes_in_words(
    served: Served, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    from lagrangian_ff.cli.main import main

    port = served.address.rstrip("/").rsplit(":", 1)[1]
    given = ["workbench", "--no-browser", "--session"]
    assert main([*given, str(tmp_path / "other"), "--port", port]) == 2
    assert "cannot be used" in capfd.readouterr().err
    (tmp_path / "broken").mkdir()
    (tmp_path / "broken" / "session.json").write_text("{}")
    assert main([*given, str(tmp_path / "broken")]) == 2
    assert "name another folder" in capfd.readouterr().err
