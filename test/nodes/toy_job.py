"""A job beside those of the package: it counts samples once the file `go` is there."""

import time
from dataclasses import dataclass
from pathlib import Path

from lagrangian_ff.nodes.common.status import Level, Status
from lagrangian_ff.nodes.recorder.jobs.base import Job, Situation
from lagrangian_ff.nodes.recorder.session import Result
from lagrangian_ff.progress import Progress
from lagrangian_ff.recording import load


@dataclass(frozen=True, kw_only=True)
class Count(Job):
    service, doing, title = "count", "counting", "size"

    @classmethod
    def request(cls, given: Situation) -> "Count":
        bags = tuple(map(str, given.session.bags))
        return cls(**given.common, bags=bags, output=str(given.directory / "go"))

    def summary(self) -> str:
        return f"started to count {len(self.bags)} recordings"

    def work(self, progress: Progress) -> Result:
        progress(0.5, "waiting")
        while not Path(self.output).exists():
            time.sleep(0.01)
        count = sum(len(load(bag, topic=self.topic)) for bag in self.bags)
        status = Status(Level.OK, f"{count} samples", {"samples": count})
        return Result((status.message,), {self.title: status})
