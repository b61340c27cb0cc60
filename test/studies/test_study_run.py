"""A study goes on where it was, and never over another's results."""

import json
from pathlib import Path

import pytest
from counting import Square, Squares

from lagrangian_ff.errors import UserError
from lagrangian_ff.studies.run import Folder, run
from lagrangian_ff.studies.study import Request
from lagrangian_ff.studies.workers import attempt


def test_what_was_done_is_not_done_again(tmp_path: Path) -> None:
    seen: list[float] = []
    some = Squares(Request(only="square-[02]"), tmp_path)
    assert [line["square"] for line in run(some, tmp_path)] == [0, 4]
    # An interruption in the middle of a line leaves what was whole.
    with Folder(tmp_path, "squares").lines.open("a", encoding="utf-8") as file:
        file.write('{"case": "square-3", "squ')
    every = Squares(Request(), tmp_path)
    lines = run(every, tmp_path, progress=lambda share, _: seen.append(share))
    assert [line["square"] for line in lines] == [0, 1, 4, 9]
    assert seen == [0.5, 0.75, 1.0]
    assert [case.tries() for case in every.every_case()] == [1, 1, 1, 1]
    assert len(Folder(tmp_path, "squares").done()) == 4


def test_an_interrupted_study_keeps_what_it_did(tmp_path: Path) -> None:
    def stop(share: float, _: str) -> None:
        if share == 0.5:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run(Squares(Request(), tmp_path), tmp_path, progress=stop)
    assert set(Folder(tmp_path, "squares").done()) == {"square-0", "square-1"}


def test_a_case_that_failed_is_tried_again(tmp_path: Path) -> None:
    line = attempt(Square(-1, tmp_path))
    assert line["failed"] == "ValueError: negative"
    study = Squares(Request(only="square-1"), tmp_path)
    run(study, tmp_path)
    folder = Folder(tmp_path, "squares")
    folder.append({"case": "square-1", "failed": "out of luck"})
    (line,) = run(study, tmp_path)
    assert line["square"] == 1


@pytest.mark.parametrize("change", [{"seed": 1}, {"version": "0.0.1"}, {"study": "cubes"}])
def test_a_folder_of_another_study_is_left_alone(tmp_path: Path, change: dict[str, object]) -> None:
    study = Squares(Request(), tmp_path)
    folder = Folder(tmp_path, "squares")
    folder.prepare({**study.identity(), **change})
    held = folder.identity.read_bytes()
    with pytest.raises(UserError, match=r"holds another study .* expected study squares"):
        run(study, tmp_path)
    assert folder.identity.read_bytes() == held
    assert not folder.lines.exists()


def test_results_of_an_unknown_study_are_left_alone(tmp_path: Path) -> None:
    (tmp_path / "cases.jsonl").write_text(json.dumps({"case": "square-1"}) + "\n")
    with pytest.raises(UserError, match=r"cases\.jsonl without study\.json"):
        run(Squares(Request(), tmp_path), tmp_path)
    (tmp_path / "study.json").write_text("{")
    with pytest.raises(UserError, match="not readable"):
        run(Squares(Request(), tmp_path), tmp_path)


def test_what_a_study_does_not_have_is_refused(tmp_path: Path) -> None:
    with pytest.raises(UserError, match="study squares has no --models"):
        Squares(Request(models=("vrbfs",)), tmp_path)
    with pytest.raises(UserError, match="--robots is 0"):
        Squares(Request(robots=0), tmp_path)
    with pytest.raises(UserError, match=r"no case is named 'cube.*square-0 and square-3"):
        run(Squares(Request(only="cube*"), tmp_path), tmp_path)
