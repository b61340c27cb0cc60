"""Search for files that break a reader: guided by coverage where atheris is, else by hypothesis."""

import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import suppress
from importlib.util import find_spec
from itertools import count
from pathlib import Path
from random import Random
from typing import Any

from fuzz.judge import judged
from fuzz.mutate import mutated
from fuzz.run import Run
from fuzz.target import Target

ROOMS = ["lagrangian_ff.recording", "lagrangian_ff.identification.storage", "lagrangian_ff.budget"]
ROOMS += [
    "lagrangian_ff.kernels.rigid",
    "lagrangian_ff.arm.trajectory",
    "lagrangian_ff.record_json",
]
"""Sources whose lines guide atheris."""


def engine(wanted: str) -> str:
    """Return the engine to search with: the one that is wanted, or the best that is installed."""
    if wanted != "auto":
        return wanted
    return "atheris" if find_spec("atheris") else "hypothesis"


def searched(run: Run, engine: str, seed: int, seconds: float) -> None:
    """Search with an engine for some seconds, and judge what it kept."""
    run.engine = engine
    if engine == "hypothesis":
        _hypothesis(run, seed, seconds)
        run.judge.close()
        return
    for content, name in _kept(run, seed, seconds):
        run.look(content, name)
    run.judge.close()


def _kept(run: Run, seed: int, seconds: float) -> Iterator[tuple[bytes, str]]:
    """Yield files that a search kept, with the names that they are to bear."""
    for clean in run.seeds:
        corpus = run.folder / f"corpus-{clean.name}"
        corpus.mkdir()
        (corpus / "clean").write_bytes(clean.read_bytes())
        found = run.folder / f"found-{clean.name}-"
        limits = [f"-max_total_time={max(1, round(seconds / len(run.seeds)))}", f"-seed={seed + 1}"]
        limits += [
            "-timeout=20",
            "-rss_limit_mb=4096",
            f"-artifact_prefix={found}",
            "-max_len=400000",
        ]
        command = [sys.executable, "-m", "fuzz.search", run.target.name, str(clean), str(corpus)]
        # What it says is for people who look at one target; the judge says what counts.
        said = subprocess.run(
            [*command, *limits],
            capture_output=True,
            text=True,
            errors="replace",
            timeout=10 * seconds + 120,
            check=False,
        )
        done = re.search(r"Done (\d+) runs", said.stderr)
        run.tried += int(done[1]) if done else 0
        for path in (*sorted(corpus.iterdir()), *sorted(found.parent.glob(f"{found.name}*"))):
            yield path.read_bytes(), clean.name


def _hypothesis(run: Run, first: int, seconds: float) -> None:
    """Search by hypothesis, which makes what breaks the reader smaller and remembers it."""
    from hypothesis import HealthCheck, Phase, given, seed, settings
    from hypothesis import strategies as st
    from hypothesis.database import DirectoryBasedExampleDatabase

    how = settings(
        max_examples=100,
        deadline=None,
        database=DirectoryBasedExampleDatabase(".hypothesis/fuzz"),
        phases=(Phase.reuse, Phase.generate, Phase.shrink),
        suppress_health_check=list(HealthCheck),
    )

    def attempt(random: Random) -> None:
        path, other = (random.choice(run.seeds) for _ in range(2))
        content = mutated(path.read_bytes(), other.read_bytes(), run.target, random)
        if not run.look(content, path.name).good:  # which keeps it, too
            raise AssertionError(path.name)

    end = time.monotonic() + seconds
    for number in count(first):
        if time.monotonic() > end:
            return
        # Several different errors come as a group, which is no AssertionError.
        with suppress(Exception):
            seed(number)(how(given(random=st.randoms(use_true_random=False))(attempt)))()


def _atheris(target: Target, clean: Path, arguments: list[str]) -> None:
    """Fuzz in this process, until the time is up or something breaks."""
    import atheris

    # Beside the corpus, in a folder that the caller removes: libFuzzer ends without cleaning up.
    place = Path(tempfile.mkdtemp(dir=Path(arguments[0]).parent)) / clean.name
    content = clean.read_bytes()

    def once(data: bytes) -> None:
        place.write_bytes(data)
        kind, text = judged(target, place)
        if kind not in ("read", "refused"):
            raise RuntimeError(text)

    def custom(data: bytes, most: int, seed: int) -> bytes:
        return mutated(bytes(data), content, target, Random(seed))[:most]

    atheris.Setup([sys.argv[0], *arguments], once, custom_mutator=custom)
    atheris.Fuzz()


def _main(name: str, clean: str, *arguments: str) -> None:
    import atheris

    with atheris.instrument_imports(include=ROOMS):
        import fuzz.targets

        found: Any = next(one for one in fuzz.targets.TARGETS if one.name == name)
    _atheris(found, Path(clean), list(arguments))


if __name__ == "__main__":
    _main(*sys.argv[1:])
