"""Where ROS logs when its usual folder cannot be written."""

from pathlib import Path

import pytest

from lagrangian_ff.nodes.common.log_folder import use_writable_log_folder


def test_a_folder_that_can_be_written_is_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("ROS_LOG_DIR", str(tmp_path / "log"))
    use_writable_log_folder()
    assert (tmp_path / "log").is_dir()
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize("home", ["/proc/nowhere", "/dev/null"])
def test_elsewhere_a_temporary_folder_is_used_and_told_once(
    home: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("ROS_LOG_DIR", "")
    monkeypatch.setenv("ROS_HOME", home)
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    use_writable_log_folder()
    said = capsys.readouterr().err
    assert said.startswith(f"ROS logs go to {tmp_path}")
    assert f"{home}/log cannot be written" in said
    use_writable_log_folder()
    assert capsys.readouterr().err == ""
