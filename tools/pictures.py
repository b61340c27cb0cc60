"""Draw the picture of the README: the arm, where a model of it fails, and how the error falls.

    python tools/pictures.py           writes docs/pictures/loop.png and loop_dark.png
    python tools/pictures.py FOLDER    keeps recordings and models there, and takes what it finds

It types the commands of docs/tutorial.md, which take some minutes.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib import image, rc_context
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from lagrangian_ff import recording  # noqa: E402
from lagrangian_ff.arm import picture  # noqa: E402
from lagrangian_ff.arm.drawing import BACKGROUND  # noqa: E402
from lagrangian_ff.arrays import Floats  # noqa: E402
from lagrangian_ff.cli.main import main  # noqa: E402
from lagrangian_ff.diagnosis import Comparison, compare  # noqa: E402
from lagrangian_ff.identification import Model  # noqa: E402

HIDDEN = ("--hidden", "stribeck@joint_3:0.1")
SLOW, FAST = ("--speed", "2", "--duration", "20"), ("--speed", "6")
COMMANDS = {
    "slow": ("simulate", *HIDDEN, *SLOW),
    "fast": ("simulate", *HIDDEN, *FAST),
    "slow_2": ("simulate", *HIDDEN, *SLOW, "--seed", "1"),
    "fast_2": ("simulate", *HIDDEN, *FAST, "--seed", "1"),
    "model.npz": ("identify", "slow", "fast", "--train", "1.0"),
    "better.npz": ("add", "model.npz", "stribeck", "--joint", "joint_3"),
}
"""What makes each file, in order."""
JOINT = 2
NEAR = 0.6  # rad/s: the speeds that are drawn
BINS = 48


class Look(NamedTuple):
    """The colours of one version of the picture, on a transparent ground."""

    file: str
    ink: str
    faint: str
    before: str
    after: str


LOOKS = (
    Look("loop.png", "#1f2328", "#59636e", "#c2410c", "#1864ab"),
    Look("loop_dark.png", "#e6edf3", "#9198a1", "#f08c4a", "#58a6ff"),
)


def made(folder: Path) -> None:
    """Type the commands whose files are not there yet."""
    for name, (command, *words) in COMMANDS.items():
        path = folder / name
        given = [str(folder / word) if word in COMMANDS else word for word in words]
        if not path.exists() and main([command, *given, "--output", str(path)]):
            raise SystemExit(1)


def compared(folder: Path) -> tuple[list[Comparison], list[Comparison]]:
    """Return how the two models do on each recording that they have not seen."""
    models = [Model.load(folder / name) for name in ("model.npz", "better.npz")]
    loaded = [recording.load(folder / name) for name in ("slow_2", "fast_2")]
    unseen = recording.condition_alike(loaded, models[0].identified.conditioning)
    first, second = ([compare(model, motion) for motion in unseen] for model in models)
    return first, second


def over_speed(runs: list[Comparison]) -> tuple[Floats, Floats, Floats, Floats]:
    """Return speed and residual of the joint, (M,) each, and the means in bins of speed."""
    speed = np.concatenate([run.motion.qd[:, JOINT] for run in runs])
    residual = np.concatenate([run.residual[:, JOINT] for run in runs])
    near = np.abs(speed) < NEAR
    speed, residual = speed[near], residual[near]
    edges = np.linspace(-NEAR, NEAR, BINS + 1)
    which = np.digitize(speed, edges) - 1
    count = np.bincount(which, minlength=BINS)
    means = np.bincount(which, residual, minlength=BINS) / np.maximum(count, 1)
    return speed, residual, (edges[1:] + edges[:-1]) / 2, np.where(count > 0, means, np.nan)


def errors(runs: list[Comparison]) -> Floats:
    """Return the error of each joint over all recordings, (N,) N·m."""
    residual = np.concatenate([run.residual for run in runs])
    return np.asarray(np.sqrt((residual**2).mean(axis=0)))


def drawn(arm: Floats, before: list[Comparison], after: list[Comparison], look: Look) -> Figure:
    """Return the picture in the colours of one ground."""
    style: dict[Any, Any] = {
        "font.size": 11.5, "text.color": look.ink, "axes.labelcolor": look.ink,
        "axes.edgecolor": look.faint, "xtick.color": look.faint, "ytick.color": look.faint,
        "axes.spines.top": False, "axes.spines.right": False, "axes.titlelocation": "left",
        "axes.titlesize": 12.5, "axes.titleweight": "bold", "axes.titlecolor": look.ink,
        "legend.frameon": False,
    }  # fmt: skip
    with rc_context(style):
        figure = Figure(figsize=(11.0, 3.7), dpi=160, layout="constrained")
        FigureCanvasAgg(figure)
        left, middle, right = figure.subplots(1, 3, width_ratios=(0.85, 1.25, 1.15))
        left.imshow(arm)
        left.set_anchor("N")
        left.axis("off")
        left.set_title("The simulated arm")

        for runs, colour, words in (
            (before, look.before, "without"),
            (after, look.after, "with Stribeck friction"),
        ):
            speed, residual, centre, mean = over_speed(runs)
            thin = max(1, len(speed) // 1500)
            middle.plot(
                speed[::thin], residual[::thin], ".", color=colour, alpha=0.25, markersize=2.5,
                markeredgewidth=0,
            )  # fmt: skip
            middle.plot(centre, mean, color=colour, linewidth=2.2, label=words)
        middle.axhline(0.0, color=look.faint, linewidth=0.7, zorder=0)
        middle.set(xlabel="speed of joint_3 [rad/s]", ylabel="torque left over [N·m]")
        middle.set_title("Where the model fails")
        middle.legend(loc="lower right", handlelength=1.2)

        joints = before[0].motion.joints
        at = np.arange(len(joints))
        right.bar(at - 0.2, errors(before), 0.38, color=look.before)
        right.bar(at + 0.2, errors(after), 0.38, color=look.after)
        right.set_xticks(at, [name.removeprefix("joint_") for name in joints])
        right.set(xlabel="joint", ylabel="error on unseen motion [N·m]")
        right.set_title("The error falls")
        right.margins(y=0.12)
        first, second = errors(before)[JOINT], errors(after)[JOINT]
        right.annotate(
            f"{first:.2f} → {second:.2f}", (JOINT, first), (0, 4), textcoords="offset points",
            ha="center",
        )  # fmt: skip
        figure.canvas.draw()
    return figure


def transparent(path: Path) -> Floats:
    """Return the picture of the arm with nothing behind it, (height, width, 4)."""
    pixels = image.imread(path)[:, :, :3]
    empty = np.all(np.abs(pixels - BACKGROUND) < 0.01, axis=2)
    cut = np.dstack([pixels, np.where(empty, 0.0, 1.0)])
    rows, columns = np.flatnonzero(~empty.all(axis=1)), np.flatnonzero(~empty.all(axis=0))
    return np.asarray(cut[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1])


def draw(folder: Path) -> None:
    """Make what the picture shows, and draw it for both grounds."""
    made(folder)
    before, after = compared(folder)
    picture(folder / "arm.png", size=900)
    arm = transparent(folder / "arm.png")
    for look in LOOKS:
        figure = drawn(arm, before, after, look)
        figure.savefig(ROOT / "docs" / "pictures" / look.file, transparent=True)


if __name__ == "__main__":
    if sys.argv[1:]:
        draw(Path(sys.argv[1]))
    else:
        with tempfile.TemporaryDirectory() as made_for_this:
            draw(Path(made_for_this))
