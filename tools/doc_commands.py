"""Run or parse every command that the documentation shows, and write the outputs that it shows.

    python tools/doc_commands.py                 runs all pages at full size, writes their outputs
    python tools/doc_commands.py docs/PAGE.md    those of one page

`test/docs/` does the same at reduced size and compares the words. What a page says of its blocks:

- A block of `bash` holds commands, one of `console` commands after `$ ` and their output, one of
  `python` code. A page is one session, in the order in which it is read, in an empty folder. `...`
  in an output stands for lines that are left out.
- `<!-- not run: REASON -->` above a block: its commands are parsed and not run.
- `<!-- page not run: REASON -->`: for every block of the page without `<!-- run -->` above.
- `<!-- begins with: NAME NAME.npz NAME.urdf -->`: a recording, a model, the simulated arm's URDF.
- `<!-- simulate: small arm -->`: at reduced size a small arm stands in for the simulated one.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import os
import re
import shlex
import shutil
import sys
import tempfile
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "tools")]

import reference  # noqa: E402
from small_arm import small_arm  # noqa: E402

from lagrangian_ff.arm import robot_description  # noqa: E402
from lagrangian_ff.cli.main import build_parser, main  # noqa: E402

PAGES = (ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md")))
LEFT_OUT = ("...", "…")
FENCE = re.compile(r"^```(?P<language>\S*)\n(?P<text>.*?)^```$", re.MULTILINE | re.DOTALL)
# Not the 3 of joint_3: that is a name.
NUMBER = re.compile(r"(?<![\w.])[-+−]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")
# What a name in capitals stands for where a number is expected.
STANDS_FOR = {"KG": "3", "PROFILE": "ur", "EFFECT@JOINT:SIZE": "stribeck@joint_3:0.1"}


class UnsoundError(Exception):
    """A command is not one of the program, or its output is not what the page shows."""


@dataclass
class Shown:
    """A command as a page shows it, with the output below it."""

    text: str
    output: list[str] = field(default_factory=list)

    @property
    def words(self) -> list[str]:
        """Return the words of the command."""
        return shlex.split(self.text, comments=True)


@dataclass
class Block:
    """A fenced block of a page.

    Args:
        place: of its text in the page, first and last character.
        reason: why it is not run, or "".
    """

    page: Path
    line: int
    language: str
    text: str
    place: tuple[int, int]
    reason: str

    @property
    def where(self) -> str:
        """Return the page and the line of the block."""
        return f"{self.page.relative_to(ROOT)}:{self.line}"

    def commands(self) -> list[Shown]:
        """Return its commands."""
        found: list[Shown] = []
        lines = iter(self.text.splitlines())
        for line in lines:
            prompt = self.language == "console" and line.startswith("$ ")
            if prompt or (self.language == "bash" and line.strip()):
                text = line.removeprefix("$ ") if prompt else line
                while text.endswith("\\"):
                    text = text[:-1] + next(lines)
                if shlex.split(text, comments=True):
                    found.append(Shown(text))
            elif self.language == "console" and found:
                found[-1].output.append(line)
        return found


def blocks(page: Path) -> list[Block]:
    """Return the fenced blocks of a page."""
    text = page.read_text(encoding="utf-8")
    whole = said(text, "page not run")
    found = []
    for match in FENCE.finditer(text):
        above = text[: match.start()].rstrip("\n").rpartition("\n")[2]
        line, place = text.count("\n", 0, match.start()) + 1, match.span("text")
        reason = "" if above == "<!-- run -->" else said(above, "not run") or whole
        found.append(Block(page, line, match["language"], match["text"], place, reason))
    return found


def said(text: str, what: str) -> str:
    """Return what a comment of the page says, or ""."""
    match = re.search(rf"^<!-- {what}: (.*) -->$", text, re.MULTILINE)
    return match[1] if match else ""


def inline(page: Path) -> list[str]:
    """Return the commands that stand within the text of a page."""
    text = FENCE.sub("", page.read_text(encoding="utf-8"))
    found = re.findall(r"`((?:lagrangian_ff|ros2|make) [^`]+)`", text)
    return [" ".join(one.split()) for one in found]


# Parsing ---------------------------------------------------------------------------------------


def parse(words: Sequence[str]) -> None:
    """Raise UnsoundError where a command is none of the program's."""
    PARSERS.get(words[0], lambda words: None)(words)


def parse_own(words: Sequence[str]) -> argparse.Namespace:
    """Return the arguments of a command of the program, parsed by the program."""
    given = [STANDS_FOR.get(word, word) for word in words[1:]]
    errors = io.StringIO()
    try:
        with contextlib.redirect_stderr(errors):
            return build_parser().parse_args(given)
    except SystemExit:
        raise UnsoundError(f"{shlex.join(words)}: {errors.getvalue()}") from None


def parse_ros2(words: Sequence[str]) -> None:
    """Raise UnsoundError for a node, launch file, argument or parameter that does not exist."""
    if words[1:3] == ["run", "lagrangian_ff"] and words[3] == "lagrangian_ff":
        if len(words) > 4:
            parse_own(words[3:])
    elif words[1:3] == ["run", "lagrangian_ff"] and words[3] != "…":
        known = declared(words[3])
        given = [words[n + 1] for n, word in enumerate(words) if word == "-p"]
        missing(known, [one.partition(":=")[0] for one in given], words)
    elif words[1:3] == ["launch", "lagrangian_ff"]:
        file = ROOT / "launch" / words[3]
        if not file.exists():
            raise UnsoundError(f"{shlex.join(words)}: there is no {file.name}")
        text = file.read_text() + (ROOT / "lagrangian_ff" / "nodes" / "launching.py").read_text()
        known = set(re.findall(r'"(\w+)"', text))
        missing(known, [one.partition(":=")[0] for one in words[4:]], words)
    elif words[1:3] == ["param", "set"]:
        missing(declared(words[3].strip("/")), [words[4]], words)
    elif words[1:3] == ["service", "call"]:
        node, _, service = words[3].strip("/").rpartition("/")
        text = "".join(path.read_text() for path in (ROOT / "lagrangian_ff/nodes").rglob("*.py"))
        if node not in reference.NODES or f"~/{service}" not in text:
            raise UnsoundError(f"{shlex.join(words)}: there is no such service")


@cache
def declared(node: str) -> set[str]:
    """Return the parameters of a node."""
    if node not in reference.NODES:
        raise UnsoundError(f"there is no node {node}")
    return {one.name for one in reference.parameters(node)}


def missing(known: set[str], given: Sequence[str], words: Sequence[str]) -> None:
    """Raise UnsoundError where a name that is given is not known; JOINT stands for any joint."""
    given = [re.sub(r"\.joint_\d", ".JOINT", name) for name in given]
    if unknown := sorted(set(given) - known - {"use_sim_time"}):
        raise UnsoundError(f"{shlex.join(words)}: {', '.join(unknown)}: no such name")


def parse_make(words: Sequence[str]) -> None:
    """Raise UnsoundError for a target that the Makefile lacks."""
    targets = set(re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(), re.MULTILINE))
    wanted = {word for word in words[1:] if "=" not in word}
    if wanted - targets - {"TARGET"}:
        raise UnsoundError(f"{shlex.join(words)}: no such target")


def parse_python(words: Sequence[str]) -> None:
    """Raise UnsoundError for a script that is not there."""
    if words[1].endswith(".py") and not (ROOT / words[1]).exists():
        raise UnsoundError(f"{shlex.join(words)}: there is no such file")


PARSERS: dict[str, Callable[[Sequence[str]], object]] = {
    "lagrangian_ff": parse_own,
    "ros2": parse_ros2,
    "make": parse_make,
    "python": parse_python,
}


def parse_inline(text: str) -> None:
    """Raise UnsoundError where a command within the text is none of the program's.

    One that is only named, or cut short with …, needs no more than its name.
    """
    words = shlex.split(text.replace("[EFFECT]", "").replace("…", " … "))
    if words[0] == "lagrangian_ff" and (len(words) == 2 or "…" in words):
        if words[1] not in {*reference.subparsers(), "COMMAND", "lagrangian_ff", "--version"}:
            raise UnsoundError(f"{text}: there is no such command")
    elif words[0] == "lagrangian_ff" and words[-1] == "--help":
        parse_inline(shlex.join(words[:2]))
    elif ("…" not in words and len(words) > 3) or words[0] != "ros2":
        parse(words)


# Running ---------------------------------------------------------------------------------------


@dataclass
class Session:
    """A page's commands, run one after the other in a folder that is there for them.

    Args:
        reduced: less data, and the words of outputs are compared; else they are written.
    """

    page: Path
    folder: Path
    reduced: bool
    ran: int = 0

    def run(self) -> str:
        """Run the page, and return its text with the outputs as they are now.

        Raises:
            UnsoundError: a command fails, or prints other words than the page shows.
        """
        text = self.page.read_text(encoding="utf-8")
        self.small = self.reduced and "<!-- simulate: small arm -->" in text
        names: dict[str, Any] = {"__name__": "page"}
        changes: list[tuple[tuple[int, int], str]] = []
        with inside(self.folder):
            self._begin(said(text, "begins with").split())
            for block in blocks(self.page):
                if block.reason:
                    continue
                if block.language == "python":
                    self._python(block, names)
                elif block.language in ("bash", "console"):
                    new = [self._shown(shown, block) for shown in block.commands()]
                    if block.language == "console":
                        changes.append((block.place, "".join(new)))
        for (first, last), new_text in reversed(changes):
            text = text[:first] + new_text + text[last:]
        return text

    def _begin(self, names: Sequence[str]) -> None:
        """Make what the page begins with."""
        for number, name in enumerate(n for n in names if Path(n).suffix in ("", ".csv")):
            small_arm(Path(name), seed=number, slow=name.startswith("slow"))
        for path in (Path(name) for name in names if name.endswith(".urdf")):
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(robot_description(), encoding="utf-8")
        for name in (name for name in names if name.endswith(".npz")):
            small_arm(Path("learned"), seed=7)
            self._call(["identify", "learned", "--output", name, *QUICK], name)

    def _shown(self, shown: Shown, block: Block) -> str:
        """Run a command, and return it with its output as it is now."""
        words = shown.words
        if words[0] != "lagrangian_ff":
            raise UnsoundError(f"{block.where}: say why {words[0]} is not run")
        parse(words)
        if words[1] == "simulate" and self.small:
            given = parse_own(words)
            output = ["..."] * bool(shown.output)
            slow = given.speed is not None and given.speed < 5
            small_arm(Path(given.output), seed=given.seed, slow=slow)
            if given.save_trajectory:
                small_arm(Path(given.save_trajectory), seed=given.seed)
        else:
            more = REDUCED.get(words[1], ()) if self.reduced else ()
            new = self._call([*words[1:], *more], block.where)
            output = agreed(shown, new, block.where)
        self.ran += 1
        return "".join(f"{line}\n" for line in (f"$ {shown.text}", *output))

    def _call(self, words: Sequence[str], where: str) -> list[str]:
        """Run a command in this process, and return the lines it prints."""
        out, err = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            code = main(list(words))
        if code:
            raise UnsoundError(f"{where}: {shlex.join(words)}: {err.getvalue()}")
        return out.getvalue().splitlines()

    def _python(self, block: Block, names: dict[str, Any]) -> None:
        """Run a block of Python in the names of those before it."""
        compiled = compile("\n" * block.line + block.text, str(self.page), "exec")
        with contextlib.redirect_stdout(io.StringIO()):
            exec(compiled, names)
        self.ran += 1


QUICK = ("--samples", "100", "--block", "1", "--train", "1.0")
REDUCED: dict[str, Sequence[str]] = {"simulate": ("--duration", "12"), "identify": QUICK[:4]}
"""What is added to a command at reduced size; the last of two equal options is taken."""


def plain(word: str) -> str:
    """Return a word with its numbers left out."""
    return NUMBER.sub("#", word)


def agreed(shown: Shown, new: Sequence[str], where: str) -> list[str]:
    """Return the shown output with the lines as they are now; what is left out stays left out.

    Lines may be broken elsewhere, since numbers are longer or shorter.

    Raises:
        UnsoundError: the words of a shown stretch are not in the new output, after those before it.
    """
    stream = [(plain(word), n) for n, line in enumerate(new) for word in line.split()]
    words = [word for word, _ in stream]
    made: list[str] = []
    begin = 0
    for stretch in stretches(shown.output):
        if stretch[0] in LEFT_OUT:
            made += stretch
            continue
        wanted = [plain(word) for line in stretch for word in line.split()]
        length = len(wanted)
        places = range(begin, len(words) - length + 1)
        at = next((n for n in places if words[n : n + length] == wanted), None)
        if at is None:
            text = "\n".join(stretch)
            raise UnsoundError(
                f"{where}: {shown.text}\ndoes not print\n{text}\nbut\n" + "\n".join(new)
            )
        if length:
            made += new[stream[at][1] : stream[at + length - 1][1] + 1]
            begin = at + length
        made += [""] * (len(stretch) - len("\n".join(stretch).rstrip("\n").split("\n")))
    return made


def stretches(lines: Sequence[str]) -> Iterator[list[str]]:
    """Yield what is shown without a gap, and each line that stands for a gap."""
    part: list[str] = []
    for line in lines:
        if line.strip() in LEFT_OUT:
            if part:
                yield part
            yield [line.strip()]
            part = []
        else:
            part.append(line)
    if part:
        yield part


@contextlib.contextmanager
def inside(folder: Path) -> Iterator[None]:
    """Work in a folder."""
    before = Path.cwd()
    os.chdir(folder)
    try:
        yield
    finally:
        os.chdir(before)


def written(page: Path, *, reduced: bool = False) -> str:
    """Return the text of a page, run in a temporary folder, with its outputs as they are now."""
    folder = Path(tempfile.mkdtemp())
    try:
        return Session(page, folder, reduced).run()
    finally:
        shutil.rmtree(folder)


if __name__ == "__main__":
    # A terminal of another width would break lines elsewhere.
    os.environ["COLUMNS"] = "100"
    for one in [Path(name).resolve() for name in sys.argv[1:]] or PAGES:
        print(one.relative_to(ROOT), flush=True)
        one.write_text(written(one), encoding="utf-8")
