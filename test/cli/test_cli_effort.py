"""`--effort`: what the effort holds, through every command that reads a recording."""

import json
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from cli_examples import arm, csv, lagrangian_ff, torque

SMALL = ("--samples", "60", "--train", "1.0")


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> Mapping[str, Path]:
    """Return recordings of the small arm, and models of them."""
    folder = tmp_path_factory.mktemp("effort")
    whole = arm()
    still = np.zeros_like(whole.position)
    # A unit of noise of 1 % of the torque, as any measurement has.
    noise = 0.1 * np.random.default_rng(0).normal(size=still.shape)
    gravity = torque(whole.position, still, still)
    return {
        "total": csv(folder / "total.csv", replace(whole, effort=whole.effort + noise)),
        "light": csv(folder / "light.csv", replace(whole, effort=whole.effort - gravity + noise)),
        "model": folder / "model.npz",
    }


def test_identify_suggests_the_option_and_the_model_keeps_it(files: Mapping[str, Path]) -> None:
    plain = lagrangian_ff(
        "identify", files["light"], *SMALL, "--output", files["model"], "--json", "-"
    )
    assert plain.code == 0, plain.err
    (check,) = json.loads(plain.out)["preflight"]
    assert check["check"] == "effort kind"
    assert "--effort without-gravity" in check["advice"]
    option = ("--effort", "without-gravity", "--force")
    told = lagrangian_ff("identify", files["light"], *SMALL, "--output", files["model"], *option)
    assert told.code == 0, told.err
    assert "no torque of gravity shows" not in told.text
    assert "effort without gravity" in told.text
    same = lagrangian_ff("compare", files["model"], files["light"])
    assert same.code == 0, same.err
    assert "effort without gravity" in same.text


def test_a_model_reads_only_its_own_kind(files: Mapping[str, Path]) -> None:
    other = lagrangian_ff("compare", files["model"], files["total"], "--effort", "total")
    assert other.code != 0
    assert "identified from an effort that is without-gravity" in other.text
    found = lagrangian_ff("diagnose", files["model"], files["total"], "--json", "-")
    assert found.code == 0, found.err
    serious = [one for one in json.loads(found.out)["preflight"] if one["serious"]]
    assert any("--effort total" in one["advice"] for one in serious)


def test_friction_that_is_compensated_is_not_modelled(files: Mapping[str, Path]) -> None:
    done = lagrangian_ff(
        "identify", files["total"], *SMALL, "--effort", "without-friction",
        "--output", files["model"].with_name("bare.npz"), "--json", "-",
    )  # fmt: skip
    assert done.code == 0, done.err
    found = json.loads(done.out)
    assert found["effects"] == []
    assert any("left over" in one["finding"] for one in found["preflight"])


def test_another_word_is_refused(files: Mapping[str, Path]) -> None:
    done = lagrangian_ff("compare", files["model"], files["light"], "--effort", "current")
    assert done.code != 0
    assert "without-gravity" in done.err
