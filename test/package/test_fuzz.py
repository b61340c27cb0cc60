"""The fuzzer judges rightly, and a second of it finds nothing."""

import os
import sys
import time
from pathlib import Path
from random import Random

import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))

from fuzz.judge import Judge  # noqa: E402
from fuzz.mutate import mutated  # noqa: E402
from fuzz.run import Run  # noqa: E402
from fuzz.target import Target  # noqa: E402
from fuzz.targets import TARGETS  # noqa: E402

from lagrangian_ff.errors import RecordingError  # noqa: E402


def _seeds(folder: Path) -> None:
    (folder / "clean.txt").write_text("good")


def _read(path: Path) -> None:
    """Do what a file says."""
    match path.read_text():
        case "refuse":
            raise RecordingError(f"{path}: refused")
        case "nameless":
            raise RecordingError("refused")
        case "raise":
            raise KeyError(path)
        case "exit":
            sys.exit(1)
        case "die":
            os.abort()
        case "slow":
            end = time.process_time() + 1.2
            while time.process_time() < end:
                pass
        case "hang":
            time.sleep(60.0)
        case "large":
            bytearray(b"x") * (600 << 20)


def test_the_judge_tells_good_from_bad(tmp_path: Path) -> None:
    path = tmp_path / "clean.txt"
    path.write_text("good")
    judge = Judge(Target("toy", _seeds, _read), [path])
    said = {}
    for deed in ("good", "refuse", "nameless", "raise", "exit", "die", "slow", "hang", "large"):
        path.write_text(deed)
        # It waits eight times as long: a busy machine must have time for what is slow.
        judge.seconds = {"large": 5.0, "slow": 1.0}.get(deed, 0.2)
        said[deed] = judge.read(path).kind
    judge.close()
    assert said == {
        "good": "read", "refuse": "refused", "nameless": "nameless", "raise": "raised",
        "exit": "raised", "die": "died", "slow": "slow", "hang": "hung", "large": "large",
    }  # fmt: skip


@pytest.mark.parametrize("target", TARGETS, ids=lambda target: target.name)
def test_damaged_files_are_read_or_refused(target: Target, tmp_path: Path) -> None:
    run = Run(target, tmp_path, tmp_path / "found")
    run.damage(seed=0, count=25, seconds=0.0)
    found = [path.read_text() for path in tmp_path.glob("found/*.txt")]
    assert not found, "\n".join(found)
    assert sum(run.counts.values()) == 25


def test_the_same_seed_gives_the_same_damage() -> None:
    target = TARGETS[0]
    first, second = (mutated(bytes(500), b"abc" * 50, target, Random(3)) for _ in range(2))
    assert first == second
