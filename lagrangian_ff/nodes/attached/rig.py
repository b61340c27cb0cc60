"""A robot in the graph, as an investigation moves it: each motion is sent, watched and recorded."""

import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from lagrangian_ff.arm.trajectory import Trajectory, write_trajectory
from lagrangian_ff.arrays import Floats
from lagrangian_ff.diagnosis.excite import Reference
from lagrangian_ff.errors import UserError
from lagrangian_ff.identification import Model
from lagrangian_ff.investigation import StoppedError
from lagrangian_ff.investigation.allowed import arm_names
from lagrangian_ff.nodes.attached.client import LOOK, Client, Told
from lagrangian_ff.progress import Progress
from lagrangian_ff.recording import Recording, load

STALL = 3.0  # s without a step forward after which a motion is given up
SILENT = 2.5  # s without a status: it comes twice a second
SETTLES = 5.0  # s until an arm that was moved stands
AFTER = 0.3  # s recorded after the end
AWAY = 0.5
"""Distance (rms) from the motion, in parts of the motion's own size, from which on an arm did not
follow it."""
SMALL = 0.02  # rad, a motion that is not judged so
NONE = "no motion is under way"


@contextmanager
def connected(
    client: Client,
    topic: str,
    joints: Sequence[str],
    urdf: Path | None,
    limits: Path | None,
    folder: Path,
) -> "Iterator[RosRig]":
    """Give the arm that a topic moves; in the end its process ends.

    Args:
        joints: from the base to the tool; empty for those that `arm_names` finds.
        urdf, limits: files that say where it may go; see `allowed`.
        folder: for motions and bags.

    Raises:
        UserError: the arm is not heard of, nobody listens on the topic, or a joint is not there.
    """
    rig = None
    try:
        client.joints()
        client.listeners(topic)
        taken = client.takes(topic)
        heard = client.every_joint(joints or taken)
        names = tuple(joints) or arm_names(heard, taken, urdf, limits)
        if lacking := [name for name in names if name not in heard]:
            raise UserError(f"no joint states of {', '.join(lacking)}; of {', '.join(heard)}")
        rig = RosRig(client, topic, names, folder)
        yield rig
    finally:
        client.close() if rig is None else rig.close()


class RosRig:
    """An arm that takes trajectories from a topic and publishes joint states.

    A motion that fails in any way is stopped before `run` raises. Motions and bags stay in the
    folder.

    Args:
        client: the process that moves it and listens.
        topic: of trajectory_msgs/JointTrajectory.
        joints: N names, from the base to the tool.
        folder: for motions and bags; is made.

    Attributes:
        bags: of the motions that were done.
    """

    def __init__(self, client: Client, topic: str, joints: tuple[str, ...], folder: Path) -> None:
        self.joints = joints
        self.bags: list[Path] = []
        self._client, self._topic, self._folder = client, topic, folder
        self._count = 0
        self._wanted, self._moving = "", False
        folder.mkdir(parents=True, exist_ok=True)

    @property
    def moving(self) -> bool:
        """Return whether `run` is under way, and ends when `stop` is called."""
        return self._moving

    @property
    def stopped(self) -> str:
        """Return why `stop` was called; empty if it was not."""
        return self._wanted

    @property
    def process(self) -> int:
        """Return the number of the process that moves the arm."""
        return self._client.pid

    def stop(self, why: str = "stopped by the user") -> None:
        """Let the arm be stopped, now and before any further motion; returns at once.

        For threads and handlers of signals.
        """
        self._wanted = self._wanted or why

    def pose(self) -> Floats:
        """Return (N,) rad, where the arm stands.

        Raises:
            StoppedError: it moves, or is not heard of.
        """
        end = time.monotonic() + SETTLES
        while True:
            try:
                return np.array(self._client.ask("pose", joints=list(self.joints))["q"])
            except UserError as error:
                if time.monotonic() > end or not self._client.alive:
                    raise StoppedError(str(error)) from error
            time.sleep(0.2)

    def run(self, motion: Reference, model: Model | None, progress: Progress) -> Recording:
        """Do a motion and return what was measured from its first point to its last.

        Raises:
            StoppedError: `stop` was called, the monitor raised the alarm, the arm does not take or
                follow the motion, the joint states ended, or the process did.
        """
        self._count += 1
        file = self._folder / f"motion_{self._count:02d}.csv"
        bag = self._folder / f"motion_{self._count:02d}"
        sent: Told = {}
        self._moving = True
        try:
            self._obey()
            write_trajectory(file, Trajectory(*motion, self.joints))
            self.pose()
            self._client.ask("record", path=str(bag))
            prepared = self._client.ask("prepare", file=str(file), topic=self._topic)
            self._obey()
            sent = self._client.ask("send", prepared=prepared["answer"])
            self._watch(sent, progress)
            time.sleep(AFTER)
            self._client.ask("finish")
        except UserError as error:
            words = self._halted(file, sent, str(error))
            raise StoppedError(words) from error
        except BaseException:
            self._halted(file, sent, "")
            raise
        finally:
            self._moving = False
        recording = self._cut(load(bag, joints=self.joints), prepared, sent)
        self._require_followed(recording, prepared, sent, motion)
        self.bags.append(bag)
        return recording

    def close(self) -> None:
        """End the process; it stops what moves."""
        self._client.close()

    def _obey(self) -> None:
        if self._wanted:
            raise StoppedError(self._wanted)

    def _watch(self, sent: Told, progress: Progress) -> None:
        """Wait for the end of the motion that was sent; raise where it must be stopped.

        Args:
            sent: its "at" becomes the start that the arm took.
        """
        client, seconds = self._client, float(sent["seconds"])
        began = gained = time.monotonic()
        elapsed, seen, told = 0.0, False, client.at
        while True:
            self._obey()
            now, status = time.monotonic(), client.status
            if not client.alive:
                raise StoppedError(f"the process in the ROS graph has ended: {client.last_words}")
            if now - client.at > SILENT:
                raise StoppedError("the process in the ROS graph does not answer")
            if client.at > told:
                told = client.at
                if status["alarm"]:
                    raise StoppedError(status["alarm"])
                if lacking := [one for one in self.joints if one not in status["joints"]]:
                    raise StoppedError(f"the joint states of {', '.join(lacking)} have ended")
                moved = status["motion"]
                if moved is None and (seen or now - began > STALL):
                    progress(1.0, "moving")
                    return
                if moved is not None:
                    seen, sent["at"] = True, moved["at"]
                    if not moved["followed"]:
                        raise StoppedError(self._refused(status))
                    if moved["elapsed"] > elapsed:
                        elapsed, gained = moved["elapsed"], now
                        progress(min(1.0, elapsed / seconds), "moving")
            if now - gained > STALL:
                raise StoppedError("the motion does not go on: the joint states have ended")
            time.sleep(LOOK)

    def _refused(self, status: Told) -> str:
        warned = [text for text in status["warnings"] if "does not follow" in text]
        return warned[-1] if warned else f"the arm refuses the motion on {self._topic}"

    def _halted(self, file: Path, sent: Told, words: str) -> str:
        """Bring the arm to rest and close the bag; return the words with what failed at that."""
        if sent:
            try:
                if not self._client.alive:
                    self._again(file, sent)
                self._client.ask("stop")
            except UserError as error:
                if NONE not in str(error):
                    words = f"{words}; it could not be stopped: {error}"
        with suppress(UserError):
            self._client.ask("finish")
        return words

    def _again(self, file: Path, sent: Told) -> None:
        """Let another process take over the motion of one that has died."""
        self._client = Client(self._client.arguments)
        self._client.joints()
        self._client.listeners(self._topic)
        self._client.ask(
            "adopt", file=str(file), topic=self._topic, at=sent["at"], **{"from": sent["from"]}
        )

    def _cut(self, recording: Recording, prepared: Told, sent: Told) -> Recording:
        """Return the recording without the way to the start, and what comes behind the end."""
        since = recording.time + (recording.start - sent["at"] / 1e9)
        rows = (since >= float(prepared["way"])) & (since <= float(sent["seconds"]) + AFTER)
        if not rows.any():
            raise StoppedError(
                f"{recording.source} holds nothing of the motion: the stamps of the joint states "
                "are not of one clock"
            )
        tables: dict[str, Any] = {name: one[rows] for name, one in recording.tables.items()}
        return replace(recording, time=recording.time[rows], **tables)

    def _require_followed(
        self, recording: Recording, prepared: Told, sent: Told, motion: Reference
    ) -> None:
        """Raise StoppedError if a motion too small to see that on the way was not followed."""
        path = Trajectory(*motion, self.joints)
        since = recording.time + (recording.start - sent["at"] / 1e9) - float(prepared["way"])
        q = path.sample(since)[0]
        size = path.q.std(axis=0)
        away = np.sqrt(np.nanmean((recording.position - q) ** 2, axis=0))
        bad = np.flatnonzero((size > SMALL) & (away > AWAY * size))
        if len(bad):
            names = ", ".join(self.joints[n] for n in bad)
            raise StoppedError(f"{names} did not follow the motion: does {self._topic} move it?")
