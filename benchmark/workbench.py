"""Measure how long the workbench takes to answer: 10 minutes of 7 joints at 500 Hz.

    python benchmark/workbench.py [--minutes 10]

A session with such a comparison is served in its own process and asked as a page asks, over HTTP.
Each figure is the median and the largest of the repetitions, as a share of the 300 ms after which
a hand feels a page wait.
"""

from __future__ import annotations

import argparse
import re
import subprocess
import sys
import tempfile
import time
import urllib.request
from pathlib import Path

import numpy as np

from lagrangian_ff.workbench.session import Card, Node, Role, Session

RATE, JOINTS, WIDTH, REPEATS = 500.0, 7, 1300, 20
BOUND = 0.3  # s
RUN = "import sys; from lagrangian_ff.cli.main import main; sys.exit(main(sys.argv[1:]))"


def make(folder: Path, minutes: float) -> None:
    """Write a session with a model that was compared with a long recording."""
    random, count = np.random.default_rng(0), round(60.0 * minutes * RATE)
    session = Session.open(folder)
    names = [f"joint_{n}" for n in range(JOINTS)]
    session.cards.append(Card("r1", "long", str(folder / "gone"), Role.CONFIRM, error="not read"))
    score = {name: {"rmse": 1.0, "nmse": 0.01} for name in names}
    compared = {"joint_names": names, "joints": score, "rmse": 1.0, "regions": [], "words": [],
                "warning": "", "seconds": count / RATE}  # fmt: skip
    described = {"name": "model", "joints": names, "effects": [], "notes": [], "seconds": 1.0}
    session.add_node(Node("m1", "", "", "learned", described, compared))
    (folder / "traces").mkdir()
    arrays = {name: random.standard_normal((count, JOINTS)).cumsum(axis=0) for name in
              ("q", "qd", "tau", "predicted", "load")}  # fmt: skip
    at = np.arange(0, count, 200)
    np.savez(folder / "traces" / "m1.npz", time=np.arange(count) / RATE, at=at,
             reach=np.ones((len(at), JOINTS)), **arrays)  # type: ignore[arg-type]  # fmt: skip


def main() -> int:
    """Print the times and return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0] if __doc__ else "")
    parser.add_argument("--minutes", type=float, default=10.0)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place) / "session"
        make(folder, given.minutes)
        command = [sys.executable, "-u", "-c", RUN, "workbench", "--session", str(folder)]
        process = subprocess.Popen(
            [*command, "--no-browser", "--port", "0"], stdout=subprocess.PIPE, text=True
        )
        try:
            assert process.stdout is not None
            found = re.search(r"workbench: (http\S+)", process.stdout.readline())
            assert found is not None
            report(found[1], 60.0 * given.minutes)
        finally:
            process.terminate()
            process.wait()
    return 0


def report(address: str, seconds: float) -> None:
    """Ask as a page does, and print how long it takes."""
    series = "".join(f"&series={n}" for n in ("tau", "predicted", "residual", "lower", "upper"))
    random = np.random.default_rng(1)

    def window(share: float) -> str:
        start = float(random.uniform(0.0, seconds * (1.0 - share)))
        return f"api/trace/m1?start={start}&end={start + share * seconds}&width={WIDTH}{series}"

    asks = {
        "the first look at it": [window(1.0)],
        "all of it": [window(1.0) for _ in range(REPEATS)],
        "a zoom to a tenth": [window(0.1) for _ in range(REPEATS)],
        "a zoom to a second": [window(1.0 / seconds) for _ in range(REPEATS)],
        "the map of the error": ["api/map/m1?x=q:1&y=qd:1&joint=q:1"] * REPEATS,
        "a rectangle on the map": ["api/chosen/m1?x=q:1&y=qd:1&left=-5&right=5&below=-5&above=5"]
        * REPEATS,
        "what is marked, on the map": ["api/lit/m1?x=q:1&y=qd:1&spans=5:60,100:130"] * REPEATS,
        "the state of the session": ["api/state"] * REPEATS,
    }
    print(f"{seconds / 60.0:g} min, {JOINTS} joints at {RATE:g} Hz, {WIDTH} pixels")
    print(f"{'':26} {'median [ms]':>12} {'largest [ms]':>13} {'of 300 ms':>10}")
    for name, paths in asks.items():
        times = []
        for path in paths:
            began = time.perf_counter()
            with urllib.request.urlopen(address + path) as answer:
                answer.read()
            times.append(time.perf_counter() - began)
        middle, most = float(np.median(times)), max(times)
        print(f"{name:26} {1e3 * middle:12.1f} {1e3 * most:13.1f} {most / BOUND:10.2f}")


if __name__ == "__main__":
    sys.exit(main())
