"""Files and folders are written whole or not at all."""

from pathlib import Path

import pytest

from lagrangian_ff.files import whole


@pytest.mark.parametrize("end", [KeyboardInterrupt, OSError, ZeroDivisionError])
def test_what_was_there_stays_when_writing_is_cut_short(
    end: type[BaseException], tmp_path: Path
) -> None:
    path = tmp_path / "model.npz"
    path.write_text("before")
    with pytest.raises(end), whole(path) as made:  # noqa: PT012
        made.write_text("half of")
        raise end
    assert path.read_text() == "before"
    assert list(tmp_path.iterdir()) == [path]


def test_a_whole_file_takes_its_place(tmp_path: Path) -> None:
    path = tmp_path / "model.npz"
    path.write_text("before")
    with whole(path) as made:
        made.write_text("after")
        assert path.read_text() == "before"
    assert path.read_text() == "after"
    assert list(tmp_path.iterdir()) == [path]


def test_a_whole_folder_takes_its_place(tmp_path: Path) -> None:
    path = tmp_path / "bag"
    path.mkdir()
    (path / "old.mcap").touch()
    with whole(path) as made:
        made.mkdir()
        (made / "new.mcap").touch()
    assert [file.name for file in path.iterdir()] == ["new.mcap"]
    assert list(tmp_path.iterdir()) == [path]


def test_a_folder_comes_back_where_the_new_one_cannot_take_its_place(tmp_path: Path) -> None:
    path = tmp_path / "bag"
    path.mkdir()
    (path / "old.mcap").touch()
    with pytest.raises(OSError, match="No such file"), whole(path):
        pass  # nothing was made
    assert [file.name for file in path.iterdir()] == ["old.mcap"]
    assert list(tmp_path.iterdir()) == [path]


def test_a_folder_that_cannot_be_written_to_is_named_by_the_file(tmp_path: Path) -> None:
    path = tmp_path / "no" / "file"
    with pytest.raises(OSError, match="No such file") as refused, whole(path):
        pass
    assert refused.value.filename == str(path)


def test_a_file_never_replaces_a_folder(tmp_path: Path) -> None:
    path = tmp_path / "named"
    path.mkdir()
    (path / "kept").touch()
    with pytest.raises(IsADirectoryError, match="folder of that name"), whole(path) as made:
        made.write_text("new")
    assert [file.name for file in tmp_path.rglob("*")] == ["named", "kept"]
