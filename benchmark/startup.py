"""How much processor time short commands take, against a bare `python -c "import numpy"`.

Looks at a made-up minute of 6 joints at 500 Hz, at a small model of it, and at the catalogue.
Prints seconds of processor time of each command as a separate process, the least of several runs,
and its ratio to importing NumPy in the same round, with its bound; and the same of importing the
nodes.
"""

import argparse
import os
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from timing import moving

from lagrangian_ff.recording import Recording, condition, write_bag, write_csv, write_npz

JOINTS = tuple(f"joint_{n + 1}" for n in range(6))
NODES = ("feedforward", "monitor", "identify", "arm")


def main() -> None:
    """Make what is looked at, then measure."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeats", type=int, default=5)
    repeats = parser.parse_args().repeats
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        make(place)
        command = ["-m", "lagrangian_ff.cli"]
        model, bag = str(place / "model.npz"), str(place / "bag")
        cases: list[tuple[str, list[str], float | None]] = [
            ("--help", [*command, "--help"], 0.4),
            ("compare --help", [*command, "compare", "--help"], 0.4),
            ("effects", [*command, "effects"], 0.4),
            ("history MODEL", [*command, "history", model], 0.4),
            ("info MODEL", [*command, "info", model], 0.4),
            ("info BAG", [*command, "info", bag], 1.0),
            ("info CSV", [*command, "info", str(place / "arm.csv")], 1.0),
            ("info NPZ", [*command, "info", str(place / "arm.npz")], 1.0),
            ("compare MODEL BAG", [*command, "compare", model, bag], 3.0),
            *(
                (f"import the node {name}", ["-c", f"import lagrangian_ff.nodes.{name}"], None)
                for name in NODES
            ),
        ]
        for name, arguments, bound in cases:
            pairs = [(seconds(["-c", "import numpy"]), seconds(arguments)) for _ in range(repeats)]
            yardstick, taken = np.min(pairs, axis=0)
            told = "" if bound is None else f" (bound {bound:g} s)"
            print(f"{name}: {taken:.2f} s, {taken / yardstick:.1f} × import numpy{told}")


def make(place: Path) -> None:
    """A minute's recording in every form, and a model of it."""
    from lagrangian_ff.identification import Settings, identify

    rng, time = np.random.default_rng(0), np.arange(30_000) / 500.0
    q, qd, _, tau = moving(rng, time, len(JOINTS))
    recording = Recording(JOINTS, time, q, qd, tau + 0.05 * rng.normal(size=tau.shape), 1.7e9)
    write_bag(place / "bag", recording)
    write_csv(place / "arm.csv", recording)
    write_npz(place / "arm.npz", recording)
    motion = condition(recording)
    identify(motion, Settings(train=1.0, samples=300, evaluations=15)).model.save(
        place / "model.npz"
    )


def seconds(arguments: Sequence[str]) -> float:
    """Return the processor time of a separate Python, from start to end."""
    silent = [(os.POSIX_SPAWN_OPEN, fd, os.devnull, os.O_WRONLY, 0) for fd in (1, 2)]
    child = os.posix_spawn(
        sys.executable, [sys.executable, *arguments], os.environ, file_actions=silent
    )
    _, status, usage = os.wait4(child, 0)
    if status != 0:
        raise RuntimeError(f"{' '.join(arguments)} ended with {os.waitstatus_to_exitcode(status)}")
    return usage.ru_utime + usage.ru_stime


if __name__ == "__main__":
    main()
