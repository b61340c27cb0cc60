"""A job beside those of the package: it counts samples once the file `go` is there."""

import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from lagrangian_ff.nodes.common.status import Level, Status
from lagrangian_ff.nodes.recorder.jobs.base import Job, Situation
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

    def work(self, progress: Progress) -> dict[str, Any]:
        progress(0.5, "waiting")
        while not Path(self.output).exists():
            time.sleep(0.01)
        return {"samples": sum(len(load(bag, topic=self.topic)) for bag in self.bags)}

    @classmethod
    def status(cls, record: Mapping[str, Any]) -> Status:
        return Status(Level.OK, f"{record['samples']} samples", record)
