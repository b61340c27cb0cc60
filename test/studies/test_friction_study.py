"""`lagrangian_ff study friction`: Fig. 3 at a small size, from the command line."""

import json
from pathlib import Path
from typing import Any

from lagrangian_ff.cli.main import main
from lagrangian_ff.studies.friction import FrictionStudy
from lagrangian_ff.studies.study import Request


def test_fri_mends_what_friction_spoils(tmp_path: Path) -> None:
    folder = tmp_path / "study"
    command = ["study", "friction", "--quick", "--jobs", "1", "--output", str(folder)]
    assert main([*command, "--robots", "3", "--cases", "n[12]-*"]) == 0
    numbers = json.loads((folder / "summary.json").read_text())
    assert not numbers["failed"]
    claims = {claim: each["joints"] for claim, each in numbers["findings"].items()}
    for kernel in ("srbfs", "vrbfs", "chain"):
        for claim in (
            f"{kernel} without fri fails at few joints",
            f"{kernel}+fri errs as where there is no friction",
        ):
            assert all(claims[claim][joints]["holds"] for joints in ("1", "2")), claim
    assert (folder / "friction.png").read_bytes().startswith(b"\x89PNG")


def line(model: str, joints: int, error: float) -> dict[str, Any]:
    return {"case": f"{model}-{joints}", "model": model, "joints": joints, "robot": 0,
            "error": error, "gamma_raised": 1.0, "frictionless": 0.1}  # fmt: skip


def test_a_claim_is_said_not_to_hold_where_it_does_not(tmp_path: Path) -> None:
    study = FrictionStudy(Request(), tmp_path)
    lines = [line("rbf", 1, 0.5), line("rbf+fri", 1, 0.1), line("rbf", 2, 0.35)]
    lines += [line("rbf+fri", 2, 0.35), line("rbf", 3, 1.9), line("rbf+fri", 3, 0.19)]
    found = study.results(lines).record()["findings"]
    said = {
        claim: {joints: row["holds"] for joints, row in each["joints"].items()}
        for claim, each in found.items()
    }
    assert said == {
        "rbf without fri fails at few joints": {"1": True, "2": False},
        "rbf+fri errs as where there is no friction": {"1": True, "2": False, "3": True},
        "rbf misses fri less than at one joint": {"2": True, "3": False},
    }
    assert study.results(lines[:1]).findings == {}


def test_every_kernel_is_there_with_fri_and_without(tmp_path: Path) -> None:
    cases = FrictionStudy(Request(robots=1), tmp_path).every_case()
    models = {case.model for case in cases}
    assert {f"{model}+fri" for model in models if "+" not in model} < models
    assert len(models) == 20
    assert len(cases) == 160
    assert FrictionStudy(Request(), tmp_path).results([]).figure().axes
