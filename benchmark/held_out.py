"""The error of several models on motion that they have not seen, joint by joint.

    python benchmark/held_out.py TRAIN [TRAIN ...] [--test TEST ...] [--share 0.33] [--models ...]
        [--samples 500]

Learns each model from the first share of TRAIN; prints the normalised mean squared error, as a
table, on the rest of it, or on TEST.
"""

import argparse
import time
from collections.abc import Sequence
from pathlib import Path

from lagrangian_ff import recording
from lagrangian_ff.diagnosis import compare
from lagrangian_ff.identification import Settings, identify
from lagrangian_ff.recording.motion import concatenate

MODELS = ("motor+fri", "rbfs+fri", "vrbfs+fri", "auto+fri")


def main() -> None:
    """Learn and judge every model."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("train", nargs="+", type=Path)
    parser.add_argument("--test", nargs="+", type=Path, default=[])
    parser.add_argument("--share", type=float, default=1.0)
    parser.add_argument("--models", nargs="+", default=list(MODELS))
    parser.add_argument("--samples", type=int, default=Settings.samples)
    options = parser.parse_args()
    learned = recording.condition_alike([recording.load(one) for one in options.train])
    like = recording.Conditioning.from_record(learned[0].conditioning)
    unseen = recording.condition_alike([recording.load(one) for one in options.test], like)
    if not unseen and options.share >= 1.0:
        parser.error("nothing is left to judge on: give --test, or --share below 1")
    rows = []
    for name in options.models:
        began = time.perf_counter()
        settings = Settings(model=name, train=options.share, samples=options.samples)
        found = identify(learned, settings)
        seconds = time.perf_counter() - began
        joints = found.model.joints
        model = found.model
        score = compare(model, concatenate(unseen)).score.record() if unseen else found.record
        each = score["joints"]
        assert isinstance(each, dict)
        cells = [f"{each[joint]['nmse']:.4f}" for joint in joints]
        rows.append([found.model.name, *cells, f"{score['nmse']:.4f}", f"{seconds:.0f} s"])
    print(_line(["model", *joints, "mean", "time"]))
    print(_line(["---"] * (len(joints) + 3)))
    for row in rows:
        print(_line(row))


def _line(cells: Sequence[str]) -> str:
    return f"| {' | '.join(cells)} |"


if __name__ == "__main__":
    main()
