"""The output folder: an earlier demo is replaced, and nothing else is touched."""

from pathlib import Path

import pytest

from lagrangian_ff.demo.folder import Folder
from lagrangian_ff.errors import UserError


def fill(folder: Folder) -> None:
    """As a demo leaves it."""
    folder.prepare()
    (folder.recording / "recording_1").mkdir(parents=True)
    (folder.recording / "recording_1" / "recording_1_0.mcap").touch()
    (folder.recording / "recording_1" / "metadata.yaml").touch()
    folder.unseen.mkdir()
    (folder.unseen / "unseen_motion_0.mcap").touch()
    for path in (folder.page, folder.record, folder.model, folder.logs / "arm.log"):
        path.touch()


def test_an_earlier_demo_is_replaced(tmp_path: Path) -> None:
    folder = Folder(tmp_path / "out")
    fill(folder)
    fill(folder)
    folder.prepare()
    assert [path.name for path in folder.root.iterdir()] == ["logs"]
    assert not list(folder.logs.iterdir())


def test_other_files_stay(tmp_path: Path) -> None:
    folder = Folder(tmp_path)
    (tmp_path / "notes.txt").write_text("mine")
    fill(folder)
    folder.prepare()
    assert (tmp_path / "notes.txt").read_text() == "mine"


def test_a_folder_that_holds_something_else_is_not_removed(tmp_path: Path) -> None:
    folder = Folder(tmp_path)
    fill(folder)
    (folder.recording / "thesis.tex").write_text("years of work")
    with pytest.raises(UserError, match=r"thesis\.tex"):
        folder.prepare()
    assert (folder.recording / "thesis.tex").exists()


def test_the_newest_bag_is_found(tmp_path: Path) -> None:
    folder = Folder(tmp_path)
    fill(folder)
    (folder.recording / "recording_1_model.npz").touch()
    assert folder.bag() == folder.recording / "recording_1"


def test_a_folder_that_cannot_be_made_is_named(tmp_path: Path) -> None:
    (tmp_path / "out").touch()
    with pytest.raises(UserError, match="out"):
        Folder(tmp_path / "out").prepare()
