"""A minute of all nodes together; `make soak` is half an hour of it."""

import sys
from pathlib import Path

import pytest

pytest.importorskip("rclpy")
pytest.importorskip("pybullet")

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))

from soak import FILES, GROWTH, MEMORY, soaked  # noqa: E402

from lagrangian_ff.demo.conductor import own_graph  # noqa: E402


def test_a_minute_grows_leaks_and_loses_nothing(
    ros_environment: dict[str, str], tmp_path: Path
) -> None:
    with own_graph(None) as (context, domain):
        found = soaked(context, domain, 60, tmp_path)
    print(found.text())
    assert (found.growth[:, MEMORY] < GROWTH).all(), found.text()
    assert (found.growth[:, FILES] <= 0).all(), found.text()
    assert found.commands > 60 * 500
    assert not found.wrong
    assert found.kept > 60 * 400
    assert not found.lost
    found.draw(tmp_path / "soak.png")
    assert (tmp_path / "soak.png").stat().st_size > 10_000
