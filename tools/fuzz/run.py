"""A run of a target: damaged files, judged and counted; what is bad is kept."""

import hashlib
import time
from collections import Counter
from pathlib import Path
from random import Random

from fuzz.judge import Judge, Verdict
from fuzz.mutate import mutated
from fuzz.target import Target


class Run:
    """A target in a folder, with the counts of what was judged."""

    def __init__(self, target: Target, folder: Path, output: Path) -> None:
        self.target, self.output = target, output
        self.clean = folder / "clean"
        self.clean.mkdir()
        target.seeds(self.clean)
        self.folder = folder
        self.seeds = sorted(self.clean.iterdir())
        self.counts: Counter[str] = Counter()
        self.worst = Verdict("read")
        self.largest = 0
        self.judge = Judge(target, self.seeds)
        self.engine = ""
        self.tried = 0

    @property
    def found(self) -> int:
        """Return how many files were not treated well."""
        return sum(self.counts.values()) - self.counts["read"] - self.counts["refused"]

    def damage(self, seed: int, count: int | None, seconds: float) -> None:
        """Judge damaged copies of the clean files, a number of them or for a time."""
        random = Random(f"{self.target.name} {seed}")
        end = time.monotonic() + seconds
        done = 0
        while done < count if count is not None else time.monotonic() < end:
            path, other = (random.choice(self.seeds) for _ in range(2))
            content = mutated(path.read_bytes(), other.read_bytes(), self.target, random)
            self.look(content, path.name)
            done += 1
        self.judge.close()

    def look(self, content: bytes, name: str) -> Verdict:
        """Return the verdict on a file, which is counted, and kept if it is bad."""
        path = self.folder / name
        path.write_bytes(content)
        verdict = self.judge.read(path)
        self.counts[verdict.kind] += 1
        self.largest = max(self.largest, verdict.memory)
        if verdict.seconds > self.worst.seconds:
            self.worst = verdict
        if not verdict.good:
            self.output.mkdir(parents=True, exist_ok=True)
            mark = hashlib.sha256(content).hexdigest()[:8]
            kept = self.output / f"{self.target.name}-{verdict.kind}-{mark}-{name}"
            kept.write_bytes(content)
            kept.with_name(f"{kept.name}.txt").write_text(f"{verdict}\n{verdict.text}")
        return verdict

    def line(self) -> str:
        """Return the result in a line."""
        kinds = ", ".join(f"{number} {kind}" for kind, number in sorted(self.counts.items()))
        files = sum(self.counts.values())
        search = f"; {self.engine}" if self.engine else ""
        search += f" tried {self.tried} more" if self.tried else ""
        return (
            f"{self.target.name:10} {files:6} files: {kinds}; at most {self.worst.seconds:.2f} s "
            f"and {self.largest >> 20} MiB{search}"
        )
