"""An investigation in a process: it asks before it moves, and can be stopped."""

import signal
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager
from dataclasses import asdict, dataclass, field
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, Any, Protocol

from lagrangian_ff.errors import UserError
from lagrangian_ff.progress import Progress
from lagrangian_ff.record_json import finite
from lagrangian_ff.recording.motion import TOTAL
from lagrangian_ff.workbench.shown import described, proposals_cards
from lagrangian_ff.worker import say

if TYPE_CHECKING:
    from lagrangian_ff.arrays import Floats
    from lagrangian_ff.diagnosis.excite import Limits, Reference
    from lagrangian_ff.diagnosis.excite.keeping import Clear
    from lagrangian_ff.identification import Model
    from lagrangian_ff.investigation import Asked, Investigation, Permit, Proposal, Rig
    from lagrangian_ff.investigation.story import Turn
    from lagrangian_ff.recording import Recording

Record = dict[str, Any]
PATIENCE = 600.0  # s for which a question waits
LOOK = 0.05  # s between looks for an answer
MOVED = 0.02  # rad by which the arm may have moved since the question
FIRST = 8.0
"""s of the first motion in each range, at least; a quarter of a short budget, as the others need
theirs."""
DRAWN = 80
"""Points of a motion that its picture has, at most."""
STOP, PERMIT, REFUSE = "stop", "permit", "refuse"


@dataclass(frozen=True)
class Wanted:
    """What a user wants of an investigation.

    Attributes:
        minutes: of motion, all in all.
        speed: share of the highest speeds.
        topic: that moves the arm.
        urdf, limits: files that say where it may go; empty for none.
    """

    minutes: float
    speed: float
    topic: str = ""
    urdf: str = ""
    limits: str = ""


@dataclass(frozen=True)
class Ready:
    """An arm that can be moved now.

    Attributes:
        rig: moves it.
        limits: that are never left.
        clear: whether a path touches anything; None where nobody knows.
        nodes: returns the nodes that take its motions.
        stop: lets the arm be stopped, for this reason; returns at once.
        moving: returns whether a motion is under way that ends by `stop`.
    """

    rig: "Rig"
    limits: "Limits"
    clear: "Clear | None"
    nodes: Callable[[], tuple[str, ...]] = tuple
    stop: Callable[[str], None] = lambda why: None
    moving: Callable[[], bool] = lambda: False


class Arm(Protocol):
    """An arm that may be investigated; it can be pickled.

    Attributes:
        real: whether its motions need a permission.
    """

    real: bool

    def opened(self, wanted: Wanted, folder: Path) -> AbstractContextManager[Ready]:
        """Give the arm; motions and bags of a robot go into the folder.

        Raises:
            UserError: it is not there, or the limits cannot be used.
        """


@dataclass(eq=False)
class Investigate:
    """Investigate an arm; its process says what it asks, does and waits for, see `said`.

    Attributes:
        arm: to move.  wanted: by the user.
        folder: for what a robot's rig writes, and for models.
        recordings: folder for a recording of each motion.
        page: the file of the report to write.
        effects: the file of the user's formulas; empty for none.
        effort, effort_delay, scale: how recordings are read; scale by joint.
        said: `asks` what is to be permitted, `steps` the questions so far, `bags` the recordings.
    """

    arm: Arm
    wanted: Wanted
    folder: str
    recordings: str
    page: str
    effects: str = ""
    effort: str = TOTAL
    effort_delay: float = 0.0
    scale: Mapping[str, float] = field(default_factory=dict)
    said: Record = field(default_factory=lambda: {"asks": None, "steps": [], "bags": []})
    _heard: list[str] = field(default_factory=list)
    _main: int = 0

    def hear(self, text: str) -> None:
        """Receive an answer, or that the arm is to be stopped; in a thread."""
        self._heard.append(text)
        if text == STOP and self._main:
            signal.pthread_kill(self._main, signal.SIGUSR1)

    def work(self, progress: Progress) -> Record:
        """Return the story; models, recordings and the page are written."""
        from lagrangian_ff.effects.user import load_effects
        from lagrangian_ff.investigation import Plan, investigate
        from lagrangian_ff.recording import Conditioning

        if self.effects:
            load_effects(self.effects)
        folder = Path(self.folder)
        folder.mkdir(parents=True, exist_ok=True)
        progress(0.0, "listening to the arm" if self.arm.real else "starting the simulated arm")
        with self.arm.opened(self.wanted, folder) as ready:
            joints = ready.rig.joints
            scale = {name: one for name, one in self.scale.items() if name in joints}
            budget = 60.0 * self.wanted.minutes
            plan = Plan(
                ready.limits,
                budget=budget,
                first=min(Plan.first, max(FIRST, budget / 4)),
                clear=ready.clear,
                conditioning=Conditioning(
                    effort=self.effort, effort_delay=self.effort_delay, effort_scale=scale
                ),
            )
            rig, permit = _Kept(ready.rig, self._keep), self._permit(ready, progress)
            with self._stoppable(ready, progress) as report:
                found = investigate(rig, plan, permit, report, self._listen)
        progress(1.0, "writing the story")
        return self._result(found)

    def _tell(self, **news: Any) -> None:
        self.said |= news
        say(finite(self.said))

    def _keep(self, recording: "Recording") -> None:
        """Write a recording, which becomes a card."""
        from lagrangian_ff.recording import write_bag

        place = Path(self.recordings)
        place.mkdir(parents=True, exist_ok=True)
        bag = write_bag(place / f"motion_{len(self.said['bags']) + 1}", recording)
        self._tell(bags=[*self.said["bags"], str(bag)])

    def _listen(self, asked: "Asked") -> None:
        steps = list(self.said["steps"])
        if asked.answer and steps:
            steps.pop()
        self._tell(steps=[*steps, asdict(asked)])

    def _permit(self, ready: Ready, progress: Progress) -> "Permit":
        """Return what asks the user, where the arm is a real one."""
        count = 0

        def permit(proposal: "Proposal") -> bool:
            nonlocal count
            count += 1
            if not self.arm.real:
                return True
            nodes, pose = ready.nodes(), ready.rig.pose()
            done = 1.0 - proposal.seconds / (60.0 * self.wanted.minutes)
            progress(done, "it waits for your permission to move")
            self._tell(asks=self._question(count, proposal, nodes, ready.clear is not None))
            try:
                if not self._answered(count):
                    return False
            finally:
                self._tell(asks=None)
            _require_same(ready, nodes, pose)
            return True

        return permit

    def _question(
        self, number: int, proposal: "Proposal", nodes: tuple[str, ...], clear: bool
    ) -> Record:
        limits = proposal.limits
        return {
            "number": number,
            "joints": list(proposal.joints),
            "topic": self.wanted.topic,
            "nodes": list(nodes),
            "seconds": proposal.seconds,
            "share": proposal.share,
            "start": proposal.start.tolist(),
            "low": limits.q_low.tolist(),
            "high": limits.q_high.tolist(),
            "fastest": limits.qd_max.tolist(),
            "clear": clear,
        }

    def _answered(self, number: int) -> bool:
        """Return whether it is permitted in time."""
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            if f"{PERMIT} {number}" in self._heard:
                return True
            if f"{REFUSE} {number}" in self._heard:
                return False
            time.sleep(LOOK)
        return False

    @contextmanager
    def _stoppable(self, ready: Ready, progress: Progress) -> Iterator[Progress]:
        """Let a stop end the investigation at once, which keeps what is known.

        Gives the progress that does so if the signal came at an inconvenient moment.
        """
        from lagrangian_ff.investigation import StoppedError

        words, asked = "stopped by the user", 0

        def stop(number: int, frame: FrameType | None) -> None:
            nonlocal asked
            asked += 1
            ready.stop(words)
            if asked == 1 and not ready.moving():  # else the rig stops the arm, then raises
                raise StoppedError(words)

        def report(done: float, label: str) -> None:
            progress(done, label)
            if asked:
                raise StoppedError(words)

        signal.signal(signal.SIGUSR1, stop)
        self._main = threading.get_ident()
        try:
            if STOP in self._heard:
                raise StoppedError(words)
            yield report
        finally:
            self._main = 0
            signal.signal(signal.SIGUSR1, signal.SIG_IGN)  # a late one must not end the process

    def _result(self, found: "Investigation") -> Record:
        from lagrangian_ff.investigation.stretches import LEARNED, STRETCH
        from lagrangian_ff.report import investigation_page

        investigation_page(self.page, found)
        last = found.turns[-1].model if found.turns else None
        read = last.identified.conditioning if last else None
        rest, names = found.unlisted, {one.effect.name for one in found.formulas}
        proposals, effects = (rest.proposals, rest.effects) if rest else ((), [])
        return finite({
            **found.record(),
            "left": list(found.left),
            "pictures": [_picture(turn) for turn in found.turns],
            "models": self._models(found),
            "learned": LEARNED,
            "stretch": STRETCH,
            "model": last.name if last else "",
            "effort_delay": read.effort_delay if read else self.effort_delay,
            "scale": {j: v for j, v in self.scale.items() if j in found.joints},
            "proposed": {
                one.joint: proposals_cards(one)
                for one in proposals
                if one.joint not in {formula.joint for formula in found.formulas}
            },
            "formulas": [one for one in effects if one["name"] in names],
        })  # fmt: skip

    def _models(self, found: "Investigation") -> list[Record]:
        """Write the last model step by step, from that without any effect that was found."""
        from lagrangian_ff.diagnosis.adding import for_history
        from lagrangian_ff.diagnosis.sentences import history_of_curve

        if not found.turns:
            return []
        last = found.turns[-1].diagnosis
        made: list[tuple[Model, Record, Record]] = [(last.model, {}, {})]
        for one, tried in last.tried:
            added: Record = {"effect": one.effect.name, "joint": one.joint}
            if one in found.formulas:
                added["shape"] = dict(one.shape)
            made.append((tried.model, added, for_history(one, last)))
        for rest in found.curves:
            assert rest.curve is not None
            assert rest.consequence is not None
            over = [one.text() for one in rest.curve.over]
            form = {"over": over, "friction": rest.curve.friction}
            named: Record = {"effect": rest.curve.name, "joint": rest.joint, "form": form}
            made.append((rest.consequence.model, named, history_of_curve(rest)))
        return [self._saved(number, *one) for number, one in enumerate(made)]

    def _saved(self, number: int, model: "Model", added: Record, why: Record) -> Record:
        file = Path(self.folder) / f"model_{number}.npz"
        model.save(file)
        return {"file": str(file), "added": added, "why": why, "described": described(model)}


class _Kept:
    """A rig whose recordings are kept."""

    def __init__(self, rig: "Rig", keep: "Callable[[Recording], None]") -> None:
        self.joints = rig.joints
        self._rig, self._keep = rig, keep

    def pose(self) -> "Floats":
        return self._rig.pose()

    def run(self, motion: "Reference", model: "Model | None", progress: Progress) -> "Recording":
        recording = self._rig.run(motion, model, progress)
        self._keep(recording)
        return recording


def _require_same(ready: Ready, nodes: tuple[str, ...], pose: "Floats") -> None:
    """Raise StoppedError if what was permitted is not what would happen."""
    from lagrangian_ff.investigation import StoppedError

    if ready.nodes() != nodes:
        raise StoppedError("other nodes take the motions now than were named: nothing moved")
    if abs(ready.rig.pose() - pose).max() > MOVED:
        raise StoppedError("the arm has moved since it was asked: nothing moved")


def _picture(turn: "Turn") -> Record:
    motion = turn.motion
    every = max(1, len(motion.time) // DRAWN)
    return {
        "joints": list(turn.model.joints),
        "seconds": float(motion.time[-1]),
        "time": motion.time[::every].round(2).tolist(),
        "q": motion.q[::every].T.round(3).tolist(),
    }


def check(wanted: Wanted) -> None:
    """Raise UserError for wishes that cannot be."""
    if not 0.15 <= wanted.minutes <= 60.0:
        raise UserError(f"{wanted.minutes:g} minutes: expected 0.15 to 60")
    if not 0.0 < wanted.speed <= 1.0:
        raise UserError(f"{100 * wanted.speed:g} % of the speed: expected above 0 and at most 100")
