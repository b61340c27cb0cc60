"""Write down what the commands compute, and show what moved between two versions of the sources.

For whoever changes how a figure is computed and not the figure::

    python tools/figures.py run FOLDER                      simulated arms, see ARMS
    python tools/figures.py run FOLDER --measured NAME=TRAIN,CONFIRM
    python tools/figures.py compare BEFORE AFTER            the largest relative difference of each

`run` drives the command line of the sources that stand in PYTHONPATH, or are installed, and keeps
its JSON, CSV and model files. Recordings in FOLDER are taken as they are, so that two versions see
the same: copy the first folder's `recordings` into the second, or name it with --recordings.
"""

from __future__ import annotations

import argparse
import csv
import json
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

ARMS = {
    "plain": (),
    "stribeck": ("--hidden", "stribeck@joint_3:0.1"),
    "ripple": ("--hidden", "ripple@joint_2:0.1"),
    "hysteresis": ("--hidden", "hysteresis@joint_5:0.1"),
    "elasticity": ("--hidden", "elasticity@joint_3:0.1"),
    "loaded": ("--loads", "joint_1=2.5", "joint_2=1"),
}
"""What the simulated arm hides; each is recorded twice, the second time to confirm on."""
SECONDS = "40"
RUNS = ("seconds", "when", "created")
"""Fields that differ from run to run."""
SAME = 1e-9


def main() -> int:
    """Run or compare."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    commands = parser.add_subparsers(dest="command", required=True)
    run = commands.add_parser("run")
    run.add_argument("folder", type=Path)
    run.add_argument("--recordings", type=Path, help="default: FOLDER/recordings")
    run.add_argument("--measured", action="append", default=[], metavar="NAME=TRAIN,CONFIRM")
    run.add_argument("--only", nargs="+", help="names of arms")
    compare = commands.add_parser("compare")
    compare.add_argument("before", type=Path)
    compare.add_argument("after", type=Path)
    options = parser.parse_args()
    if options.command == "compare":
        return compared(options.before, options.after)
    recordings = options.recordings or options.folder / "recordings"
    pairs: dict[str, tuple[str, ...]] = {name: simulated(recordings, name) for name in ARMS}
    for one in options.measured:
        name, _, files = one.partition("=")
        pairs[name] = tuple(str(Path(file).resolve()) for file in files.split(","))
    for name, pair in pairs.items():
        if not options.only or name in options.only:
            compute(options.folder / name, *pair)
    return 0


def call(folder: Path, *arguments: str) -> bool:
    """Call the command line in a folder; say what it refused."""
    command = [sys.executable, "-m", "lagrangian_ff.cli", *arguments]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    name = f"{folder.name}: {arguments[0]}"
    print(name if done.returncode == 0 else f"{name}: {done.stderr.strip()}", flush=True)
    return done.returncode == 0


def simulated(recordings: Path, name: str) -> tuple[str, str]:
    """Return two recordings of a simulated arm, made where they are not there."""
    recordings.mkdir(parents=True, exist_ok=True)
    for seed in ("0", "1"):
        bag = f"{name}_{seed}"
        if not (recordings / bag).exists():
            motion = "--seed", seed, "--duration", SECONDS
            saved = "--save-trajectory", f"{bag}.csv"
            call(recordings, "simulate", *motion, *ARMS[name], *saved, "--output", bag)
    first, second = (str((recordings / f"{name}_{seed}").resolve()) for seed in ("0", "1"))
    return first, second


def compute(folder: Path, train: str, confirm: str) -> None:
    """Write all that is computed from a pair of recordings to a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    json_to = "--force", "--json"
    if not call(folder, "identify", train, "--output", "model.npz", *json_to, "identify.json"):
        return
    call(folder, "compare", "model.npz", confirm, *json_to, "compare.json")
    call(folder, "predict", "model.npz", confirm, "--output", "predict.csv", "--force")
    confirmed = "--confirm", confirm
    call(folder, "diagnose", "model.npz", train, *confirmed, *json_to, "diagnose.json")
    call(folder, "diagnose", "model.npz", confirm, "--since", *json_to, "since.json")
    joint = json.loads((folder / "identify.json").read_text())["joints"]
    last = list(joint)[-1]
    new = "--joint", last, "--output", "added.npz"
    call(folder, "add", "model.npz", "stribeck", *new, *json_to, "add.json")
    if Path(f"{confirm}.csv").exists():
        new = f"{confirm}.csv", "--output", "torque.csv", "--force"
        call(folder, "feedforward", "model.npz", *new)


def compared(before: Path, after: Path) -> int:
    """Print for every file the figure that moved most, and what is no number and changed."""
    moved = 0
    for old in sorted(before.rglob("*")):
        if old.suffix not in {".json", ".csv", ".npz"} or "recordings" in old.parts:
            continue
        name = old.relative_to(before)
        new = after / name
        if not new.exists():
            print(f"{name}: absent")
            moved += 1
            continue
        largest, where = 0.0, ""
        for place, difference in differences(content(old), content(new)):
            if isinstance(difference, str):
                print(f"{name} {place}: {difference}")
                moved += 1
            elif difference > largest:
                largest, where = difference, place
        moved += largest > SAME
        print(f"{name}: {largest:.1e} {where}")
    return min(moved, 1)


def content(path: Path) -> Any:
    """Return what a file holds, as mappings, lists, arrays and numbers."""
    if path.suffix == ".json":
        return json.loads(path.read_text())
    if path.suffix == ".csv":
        with path.open() as file:
            header, *rows = csv.reader(file)
        return {"header": header, "rows": np.array(rows, dtype=np.float64)}
    with np.load(path, allow_pickle=False) as archive:
        return {name: whole(archive[name]) for name in archive.files}


def whole(array: Any) -> Any:
    """Return an array, or what it holds where that is JSON."""
    if array.dtype.kind not in "Uu":
        return array
    try:
        return json.loads(array.tobytes() if array.dtype.kind == "u" else str(array))
    except ValueError:
        return array


def differences(old: Any, new: Any, place: str = "") -> Iterator[tuple[str, float | str]]:
    """Yield how far two contents lie apart, and where; words where they are no numbers."""
    if isinstance(old, dict) and isinstance(new, dict):
        for name in {**old, **new}:
            if name in RUNS:
                continue
            if name not in old or name not in new:
                yield f"{place}/{name}", "new" if name in new else "gone"
            else:
                yield from differences(old[name], new[name], f"{place}/{name}")
    elif isinstance(old, list) and isinstance(new, list) and len(old) == len(new):
        for number, (one, other) in enumerate(zip(old, new, strict=True)):
            yield from differences(one, other, f"{place}/{number}")
    elif isinstance(old, np.ndarray) and isinstance(new, np.ndarray) and old.shape == new.shape:
        if old.dtype.kind in "fiub" and old.size:
            scale = max(float(np.nanmax(np.abs(old))), 1e-300)
            yield place, float(np.nanmax(np.abs(new.astype(float) - old.astype(float)))) / scale
        elif not np.array_equal(old, new):
            yield place, "differs"
    elif isinstance(old, (int, float)) and isinstance(new, (int, float)):
        if old != new and not (old != old and new != new):
            yield place, abs(new - old) / max(abs(old), abs(new))
    elif old != new:
        yield place, f"{old!r} is now {new!r}"[:200]


if __name__ == "__main__":
    sys.exit(main())
