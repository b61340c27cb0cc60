"""Fixtures for every room's tests.

Kept to one file on purpose: a second conftest.py elsewhere would be a second module of that name.
"""

from __future__ import annotations

import fcntl
import os
import random
import sys
import tempfile
from collections.abc import Generator, Iterator
from pathlib import Path
from typing import IO, Any

import pytest
from hypothesis import HealthCheck, settings

MISSING = (
    "the simulated arm needs PyBullet",
    "No module named 'pybullet'",
    "No module named 'rosbags'",
    "No module named 'mcap'",
    "No module named 'zstandard'",
    "No module named 'lz4'",
)
ROOT = Path(__file__).resolve().parent.parent

os.environ.setdefault("MPLBACKEND", "Agg")
# Tests run in as many processes as there are processors: threads of BLAS beside them spend four
# times the work on waiting for each other. To be set before NumPy is imported.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

# Machines differ in speed, so no example has a deadline; CI tries the same examples every time.
settings.register_profile(
    "lagrangian_ff",
    deadline=None,
    derandomize="CI" in os.environ,
    suppress_health_check=[HealthCheck.too_slow],
)
settings.load_profile("lagrangian_ff")


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the option that `make test` has for tests of processes."""
    words = "a file or folder whose tests share a worker with those of all others so named"
    parser.addoption("--one-worker", action="append", default=[], metavar="PATH", help=words)


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Any:
    """Return a scheduler that gives one worker all tests of `--one-worker`; None without any."""
    from xdist.scheduler import LoadFileScheduling  # type: ignore[import-untyped]

    shared = tuple(config.getoption("--one-worker"))
    if not shared:
        return None

    class Scheduling(LoadFileScheduling):
        def _split_scope(self, nodeid: str) -> str:
            return "one worker" if nodeid.startswith(shared) else nodeid.split("::")[0]

    return Scheduling(config, log)


def pytest_configure(config: pytest.Config) -> None:
    """Let test processes take files in their order, not those with the most tests first."""
    config.option.loadscopereorder = False


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Keep the order of the arguments: newer versions of pytest take a folder once, as a whole."""
    given = config.args

    def place(item: pytest.Item) -> int:
        starts = (n for n, one in enumerate(given) if item.nodeid.startswith(one))
        return next(starts, len(given))

    items.sort(key=place)


@pytest.hookimpl(wrapper=True)
def pytest_make_collect_report(
    collector: pytest.Collector,
) -> Generator[None, pytest.CollectReport, pytest.CollectReport]:
    """Skip the files that import a library which is optional and not there."""
    report = yield
    missing = [words for words in MISSING if report.failed and words in str(report.longrepr)]
    if missing:
        report.outcome = "skipped"
        report.longrepr = (str(collector.path), 0, f"Skipped: {missing[0]}")
    return report


@pytest.fixture(scope="session")
def root() -> Path:
    """Return the root of the source tree."""
    return ROOT


@pytest.fixture(scope="session")
def shared() -> Path:
    """Return the folder of measured recordings and reference values beside the source tree."""
    folder = ROOT.parent / "shared"
    if not folder.is_dir():
        pytest.skip("no measured data: the folder ../shared is not beside the source tree")
    return folder


@pytest.fixture(scope="session")
def shared_data(shared: Path) -> Path:
    """Return the folder of measured recordings."""
    folder = shared / "data"
    if not folder.is_dir():
        pytest.skip("no measured data: ../shared/data is absent")
    return folder


def _claim_domain() -> tuple[int, IO[str]]:
    """Return a ROS domain that no other test session on this machine uses, and the lock on it."""
    domains = list(range(1, 102))  # above 101 DDS's ports may meet those that Linux gives out
    random.SystemRandom().shuffle(domains)
    for domain in domains:
        lock = (Path(tempfile.gettempdir()) / f"lagrangian_ff_test_domain_{domain}").open("w")
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            lock.close()
        else:
            return domain, lock
    raise RuntimeError("all ROS domains are taken by other test sessions")


@pytest.fixture(scope="session")
def ros_environment(tmp_path_factory: pytest.TempPathFactory) -> Iterator[dict[str, str]]:
    """Return the environment variables for ROS processes of this test session alone.

    Discovery stays on this machine and in a domain of its own. The variables are also set in the
    test process itself, before the first context is initialised.
    """
    pytest.importorskip("rclpy", reason="rclpy is not installed")
    domain, lock = _claim_domain()
    prefixes = [*filter(None, os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep))]
    # With ROS from wheels, the root of the Python environment is itself an ament prefix.
    if sys.prefix not in prefixes and (Path(sys.prefix) / "share" / "ament_index").is_dir():
        prefixes.append(sys.prefix)
    ours = {
        "ROS_DOMAIN_ID": str(domain),
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
        "ROS_LOG_DIR": str(tmp_path_factory.mktemp("ros_log")),
        "AMENT_PREFIX_PATH": os.pathsep.join(prefixes),
        "PYTHONUNBUFFERED": "1",
    }
    with pytest.MonkeyPatch.context() as patch:
        for name, value in ours.items():
            patch.setenv(name, value)
        yield dict(os.environ)
    lock.close()


@pytest.fixture(autouse=True)
def processes_end_with_their_test(request: pytest.FixtureRequest) -> Iterator[None]:
    """End what a test started on a bench of its module; what the fixtures started stays.

    A simulated arm takes a processor: the next test would be late.
    """
    if "bench" not in request.fixturenames:
        yield
        return
    with request.getfixturevalue("bench").passing():
        yield


@pytest.fixture
def catalogue_kept() -> Iterator[None]:
    """Take effects of a user out of the catalogue again, which a test has loaded."""
    from lagrangian_ff.effects import EFFECTS
    from lagrangian_ff.effects.base import BROUGHT

    before = set(EFFECTS)
    yield
    for name in set(EFFECTS) - before:
        del EFFECTS[name], BROUGHT[name]
