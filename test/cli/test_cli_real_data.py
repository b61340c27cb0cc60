"""A measured recording of a real arm, as it came."""

import json
from pathlib import Path

from cli_examples import process

FILE = "ur10/ur10_exciting_trajectory/ur10_exciting_trajectory.db3"


def test_a_measured_ur10_is_identified_as_the_file_is(shared_data: Path, tmp_path: Path) -> None:
    model, found = tmp_path / "ur10.npz", tmp_path / "found.json"
    outcome = process(
        "identify", shared_data / FILE, "--model", "chain+fri", "--samples", "60",
        "--train", "1.0",
        "--output", model, "--json", found,
    )  # fmt: skip
    assert outcome.code == 0, outcome
    record = json.loads(found.read_text())
    assert len(record["joints"]) == 6
    assert record["nmse"] < 0.2
    friction = {
        (entry["effect"], entry["joint"]): next(iter(entry["parameters"].values()))
        for entry in record["effects"]
    }
    # Strong friction, as its owners say: on the large joints it is beyond doubt.
    for joint in ("shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint"):
        assert friction["coulomb", joint]["low"] > 0.0
    assert "3441 samples in 27.520 s, 125 Hz" in outcome.text
    assert "The model is" in outcome.text
