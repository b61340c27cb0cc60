"""The workbench's other end in the graph: streams residuals, records, and sends motions.

    python -m lagrangian_ff.nodes.live --ros-args -r joint_states:=/TOPIC

The workbench starts it and talks to it in lines of JSON. A command on standard input is
{"id": NUMBER, "do": WORD, ...}; its answer on standard output is {"answer": NUMBER, ...}, with
"error" if it was refused. Events come unasked: {"event": "samples"} ten times a second,
{"event": "status"} twice. It ends when its standard input does, so that it does not outlive a
killed workbench; it then stops the motion that it has sent, and closes the recording.

Topics
    joint_states   in   sensor_msgs/JointState; best effort, so that every publisher matches
    /diagnostics   in   a touch that a node `monitor` reports stops the motion under way at once
    any            out  trajectory_msgs/JointTrajectory, at the commands `send` and `stop`, and at
                        a touch
"""

import json
import os
import signal
import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import suppress
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.clock import Clock, ClockType
from sensor_msgs.msg import JointState

from lagrangian_ff.errors import UserError
from lagrangian_ff.nodes.attached.bins import Bins
from lagrangian_ff.nodes.attached.poses import Poses
from lagrangian_ff.nodes.attached.sender import Sender
from lagrangian_ff.nodes.common.joint_state_bytes import (
    JointStateReader,
    JointStateView,
    MessageError,
)
from lagrangian_ff.nodes.common.models import conditioning_for, load_model, load_own_effects
from lagrangian_ff.nodes.common.node import ClosingNode, run
from lagrangian_ff.nodes.common.pacing import PacedThread, Pacer, RateMeter
from lagrangian_ff.nodes.common.topics import RECORDING, PolledSubscription
from lagrangian_ff.nodes.recorder.bag_recorder import BagRecorder, free_space, lasting
from lagrangian_ff.nodes.watching.health import Health, Limits
from lagrangian_ff.nodes.watching.live import LivePrediction
from lagrangian_ff.nodes.watching.states import LiveStates
from lagrangian_ff.record_json import finite

PERIOD = 0.02  # s between readings of the topic
MOST = 1000
"""Messages taken at one reading; more wait for the next."""
EVERY = 5  # readings between two events of samples
TOLD = 0.5  # s between two events of status
RATE = 100.0  # Hz of prediction and residual
LASTS = 5.0  # s for which a warning is shown
RESERVE = 500_000_000  # bytes of the disk that a recording leaves free
LAYOUTS = 16
"""Most kinds of joint states that are drawn: parts of a robot that share the topic."""
LIMITS = Limits(window=5.0, still=0.01, margin=0.25, warn=2.0, error=4.0)
ENDING = 8.0  # s in which the process ends by itself
MONITOR, OK = "monitor", bytes([0])
"""The node whose touches count, and the level at which there is none."""

Record = dict[str, Any]
Say = Callable[[Record], None]


class Watch:
    """A model beside the joint states.

    Args:
        file: of the model.
        effects: the file of effects of the user's own; empty for none.

    Attributes:
        joints: of the model.

    Raises:
        UserError: one of them cannot be used.
    """

    def __init__(self, file: str, effects: str) -> None:
        load_own_effects(effects)
        self.model, _ = load_model(file)
        self.joints = joints = self.model.joints
        self._states = LiveStates(joints, conditioning_for(self.model, {}, {}), RATE)
        self._prediction = LivePrediction(self.model)
        self._health = Health(joints, self.model.identified.score, self.model.range)
        self._lock = threading.Lock()  # the executor asks while states come
        self._bins: Bins | None = None

    def take(
        self, views: list[tuple[JointStateView, int]], warn: Callable[[str, str], None]
    ) -> None:
        """Take joint states, each with its time of reception in ns."""
        states = []
        for view, received in views:
            try:
                state = self._states.take(view, received)
            except MessageError as error:
                warn("bad joint state", f"ignored {error}")
                continue
            if state is not None:
                states.append(state)
        for judged in self._prediction.take(states):
            state = judged.state
            with self._lock:
                self._health.add(judged, LIMITS)
            if self._bins is None:
                names = ("measured", "predicted", "residual")
                self._bins = Bins(self.model.joints, names, state.at)
            self._bins.add(state.at, np.stack([state.tau, judged.predicted, judged.residual]))

    def samples(self) -> list[Record | None]:
        """Return what is to be drawn since the last call."""
        return [self._bins.take()] if self._bins else []

    def status(self) -> Record:
        """Return the delay in s and the rms residual by joint in N·m, None for joints that rest."""
        with self._lock:
            rms = self._health.rms().tolist()
        late = self._states.delay + self._prediction.waits / RATE
        return {"delay": late, "rms": dict(zip(self.model.joints, rms, strict=True))}


class RawTorque:
    """Measured torque as it comes, while there is no model.

    Attributes:
        joints: none that have to be there.
    """

    joints: tuple[str, ...] = ()

    def __init__(self) -> None:
        self._bins: dict[tuple[str, ...], Bins] = {}
        self._start = 0

    def take(
        self, views: list[tuple[JointStateView, int]], warn: Callable[[str, str], None]
    ) -> None:
        """Take joint states, each with its time of reception in ns."""
        for view, received in views:
            if not len(view.effort):
                continue
            at = view.stamp or received
            self._start = self._start or at
            if view.names not in self._bins and len(self._bins) < LAYOUTS:
                self._bins[view.names] = Bins(view.names, ("measured",), self._start)
            if view.names in self._bins:
                self._bins[view.names].add(at, view.effort[None].astype(np.float64))

    def samples(self) -> list[Record | None]:
        """Return what is to be drawn since the last call."""
        return [bins.take() for bins in self._bins.values()]

    def status(self) -> Record:
        """Return that there is nothing to compare."""
        return {"delay": 0.0, "rms": {}}


class LiveNode(ClosingNode):
    """Four threads: one reads the topic and writes bags, one watches, one does commands, and the
    executor reports.

    Args:
        say: writes an event or an answer.
    """

    def __init__(self, say: Say) -> None:
        super().__init__("workbench")
        self._say = say
        self._warned: dict[str, tuple[float, str]] = {}
        self._subscription = PolledSubscription(
            self, JointState, "joint_states", RECORDING, raw=True
        )
        self._passed: deque[tuple[bytes, int]] = deque(maxlen=RECORDING.depth)
        self._recorder = BagRecorder(self._take, self._warn)
        self._path: Path | None = None
        self._reader, self._meter, self._poses = JointStateReader(), RateMeter(), Poses()
        self._watch: Watch | RawTorque = RawTorque()
        self._wanted = 0
        self._sender = Sender(self, self._poses, self._warn)
        self._commands: dict[str, Callable[[int, Record], Record | None]] = {
            "model": self._model,
            "record": self._record,
            "finish": self._finish,
            "prepare": lambda number, asked: self._sender.prepare(
                number, str(asked["file"]), str(asked["topic"])
            ),
            "send": lambda number, asked: self._sender.send(int(asked["prepared"])),
            "stop": lambda number, asked: self._sender.stop(),
            "adopt": lambda number, asked: self._sender.adopt(
                str(asked["file"]), str(asked["topic"]), np.array(asked["from"]), int(asked["at"])
            ),
            "takes": lambda number, asked: {"joints": self._sender.takes(str(asked["topic"]))},
            "pose": lambda number, asked: {"q": self._poses.standing(asked["joints"]).tolist()},
        }
        self.create_subscription(DiagnosticArray, "/diagnostics", self._on_diagnostics, 100)
        self._readings = 0
        self._rates: deque[float] = deque(maxlen=4)
        self._loop = PacedThread(Pacer(PERIOD), self._look, self._failed, "watch")
        self.create_timer(TOLD, self._tell, clock=Clock(clock_type=ClockType.STEADY_TIME))
        threading.Thread(target=self._obey, name="commands", daemon=True).start()

    def _take(self) -> Iterator[tuple[bytes, int]]:
        """Yield the waiting messages to the recorder, and keep them for the watch."""
        for each in self._subscription.take():
            self._passed.append(each)
            yield each

    def _warn(self, kind: str, text: str) -> None:
        self._warned[kind] = time.monotonic(), text

    def _failed(self, error: Exception) -> None:
        self._warn("failure", f"could not compare: {type(error).__name__}: {error}")

    def _look(self, due: range) -> None:
        """Take the messages that came; in the paced thread."""
        watch, views = self._watch, []
        for data, received in islice(iter(self._next, None), MOST):
            self._meter.add()
            try:
                view = self._reader.read(data)
            except MessageError:
                continue  # the recorder says so
            self._check(view)
            if not view.fault():
                self._poses.take(view, view.stamp or received)
            views.append((view, received))
        watch.take(views, self._warn)
        self._readings += 1
        if self._readings % EVERY == 0:
            for found in watch.samples():
                if found is not None:
                    self._say({"event": "samples", **found})

    def _next(self) -> tuple[bytes, int] | None:
        return self._passed.popleft() if self._passed else None

    def _check(self, view: JointStateView) -> None:
        if not len(view.effort):
            self._warn("no effort", "joint states come without effort: there is nothing to compare")
        elif not (finite_ := np.isfinite(view.effort)).all():
            joint = view.names[int(finite_.argmin())]
            self._warn("bad effort", f"the effort of {joint} is not a finite number")

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        """Raise the alarm at a touch that a monitor reports."""
        for status in message.status:
            node, _, part = status.name.rpartition(": ")
            if part == "touch" and node.split("/")[-1] == MONITOR and status.level > OK:
                self._sender.raise_alarm(f"{node}: {status.message}")

    def _tell(self) -> None:
        """Say the state; in the executor."""
        self._sender.look()
        heard = self._poses.joints
        lacking = [joint for joint in self._watch.joints if joint not in heard]
        if heard and lacking:
            words = f"joint states without {', '.join(lacking)}, which the model has"
            self._warn("joints", f"{words}: there is nothing to compare")
        self._rates.append(self._meter.take())
        now, topic, tally = time.monotonic(), self._subscription.topic, self._recorder.tally
        warned = [text for at, text in list(self._warned.values()) if now - at < LASTS]
        recording = {
            "samples": tally.samples,
            "seconds": tally.seconds,
            "ended": self._recorder.failure,
        }
        self._say({
            "event": "status",
            "topic": topic,
            "publishers": self.count_publishers(topic),
            "rate": sum(self._rates) / len(self._rates),
            "joints": list(heard),
            "warnings": list(dict.fromkeys(warned)),
            "recording": recording if self._path else None,
            "topics": self._sender.topics(),
            "motion": self._sender.running(),
            "alarm": self._sender.alarm,
            **self._watch.status(),
        })  # fmt: skip

    def _obey(self) -> None:
        """Do the commands on standard input, and end with it; in a thread."""
        # Unbuffered: the interpreter's end would wait for the lock of a buffer.
        with os.fdopen(0, "rb", buffering=0, closefd=False) as lines:
            for line in iter(lines.readline, b""):
                try:
                    asked = json.loads(line)
                    number, do = int(asked["id"]), self._commands[asked["do"]]
                except (ValueError, KeyError, TypeError):
                    continue  # no command
                self._answer(number, do, asked)
        end_now()

    def _answer(
        self, number: int, do: Callable[[int, Record], Record | None], asked: Record
    ) -> None:
        try:
            answer = do(number, asked)
        except (UserError, OSError) as error:
            answer = {"error": str(error)}
        except Exception as error:  # whatever comes, the next command is done
            answer = {"error": f"unexpected {type(error).__name__}: {error}"}
        if answer is not None:
            self._say({"answer": number, **answer})

    def _model(self, number: int, asked: Record) -> None:
        """Compare with another model, or with none; loading it must not delay a stop."""

        def load(number: int, asked: Record) -> Record:
            file = str(asked["file"])
            watch = Watch(file, str(asked["effects"])) if file else RawTorque()
            if number == self._wanted:
                self._watch = watch
            return {"file": file}

        self._wanted = number
        threading.Thread(
            target=self._answer, args=(number, load, asked), name="model", daemon=True
        ).start()

    def _record(self, number: int, asked: Record) -> Record:
        path = Path(str(asked["path"]))
        if self._path is not None:
            raise UserError(f"recording to {self._path} already")
        path.parent.mkdir(parents=True, exist_ok=True)
        if (free := free_space(path.parent)) < RESERVE:
            raise UserError(f"{path.parent} has only {free / 1e9:.2f} GB left: delete recordings")
        self._recorder.open(path, self._subscription.topic, RESERVE)
        self._path = path
        return {"path": str(path), "lasts": lasting(free, RESERVE, self._recorder.rate)}

    def _finish(self, number: int, asked: Record) -> Record:
        path, self._path = self._path, None
        if path is None:
            raise UserError("not recording")
        self._recorder.close_bag()
        tally, ended = self._recorder.tally, self._recorder.failure
        return {
            "path": str(path),
            "samples": tally.samples,
            "seconds": tally.seconds,
            "ended": ended,
        }

    def close(self) -> None:
        """Stop the motion under way, and end the bag properly."""
        if self._sender.running() is not None:
            with suppress(UserError):  # nobody is there to be told
                self._sender.stop()
        self._loop.stop()
        self._recorder.stop()


def end_now() -> None:
    """End this process as a signal does; at once if that takes long."""
    os.kill(os.getpid(), signal.SIGTERM)
    time.sleep(ENDING)
    os._exit(3)


def main() -> int:
    """Run until standard input ends and return the exit code."""
    lock = threading.Lock()

    def say(event: Record) -> None:
        line = json.dumps(finite(event), ensure_ascii=False)
        with lock:
            try:
                print(line, flush=True)
            except BrokenPipeError:  # the end of standard input comes, too
                return

    return run(lambda: LiveNode(say), sys.argv)


if __name__ == "__main__":
    sys.exit(main())
