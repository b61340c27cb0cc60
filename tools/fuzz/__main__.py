"""Fuzz the readers: `make fuzz`, or from the root `PYTHONPATH=tools python -m fuzz`.

Judged are damaged copies of clean files. Good is what is read, or refused with an error of the
package that names the file, within 5 s or three times the clean file's time, and 500 MB beyond its
memory. With atheris, which is installed where it has a wheel, damage is guided by the lines that it
reaches; without it hypothesis searches, and keeps what it found in .hypothesis. What is found lies
in --output, with the error beside it.
"""

import argparse
import sys
import tempfile
from pathlib import Path

from fuzz import search
from fuzz.run import Run
from fuzz.targets import TARGETS


def main() -> int:
    """Fuzz the targets; return 1 if anything was found."""
    names = [target.name for target in TARGETS]
    parser = argparse.ArgumentParser("fuzz", description=__doc__)
    parser.add_argument("targets", nargs="*", metavar="TARGET", help=f"of {', '.join(names)}")
    parser.add_argument("--seconds", type=float, default=210.0, help="in all, default 210")
    parser.add_argument("--count", type=int, help="judge this many files a target instead")
    parser.add_argument("--seed", type=int, default=0, help="of the damage")
    parser.add_argument(
        "--engine", choices=("auto", "atheris", "hypothesis", "none"), default="auto"
    )
    parser.add_argument("--output", type=Path, default=Path("out/fuzz"))
    options = parser.parse_args()
    if wrong := set(options.targets) - set(names):
        parser.error(f"no target {', '.join(sorted(wrong))}; expected some of {', '.join(names)}")
    chosen = [target for target in TARGETS if target.name in (options.targets or names)]
    share = options.seconds / len(chosen)
    found = 0
    for target in chosen:
        with tempfile.TemporaryDirectory(prefix="fuzz-") as folder:
            run = Run(target, Path(folder), options.output)
            if options.count is not None or options.engine == "none":
                run.damage(options.seed, options.count, share)
            else:
                run.damage(options.seed, None, 0.4 * share)
                engine = search.engine(options.engine)
                search.searched(run, engine, options.seed, 0.6 * share)
            print(run.line(), flush=True)
            found += run.found
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
