"""Write the reference pages of the documentation from the program itself.

Called by docs/conf.py; `python tools/reference.py FOLDER` writes them by hand.
"""

from __future__ import annotations

import argparse
import ast
import importlib
import inspect
import json
import re
import sys
from collections.abc import Iterator, Sequence
from itertools import pairwise
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple

ROOT = Path(__file__).resolve().parents[1]
ROOMS = (
    "recording", "identification", "kernels", "effects", "diagnosis", "investigation", "export",
    "report", "arm",
)  # fmt: skip
"""The rooms whose names are for users of Python."""
NODES = ("identify", "feedforward", "monitor", "watchdog", "arm")
SCHEMA = ROOT / "lagrangian_ff" / "export" / "model.schema.json"


class Declared(NamedTuple):
    """A parameter as a node declares it."""

    name: str
    default: Any
    description: str
    allowed: str
    when: str


class Declarations:
    """What stands in for the parameters of a node, and keeps what is declared."""

    def __init__(self) -> None:
        self.found: list[Declared] = []

    def declare(self, name: str, default: Any, description: str, **more: Any) -> Any:
        """Keep a parameter and return its default."""
        low, high = more.get("low"), more.get("high")
        allowed = f"{low:g} to {high:g}" if low is not None and high is not None else ""
        allowed = ", ".join(more.get("choices", ())) or allowed
        when = "at the start" if more.get("read_only") else "at any time"
        self.found.append(Declared(name, default, description, allowed, when))
        return default


def parameters(node: str) -> list[Declared]:
    """Return the parameters of a node; JOINT stands for each joint's name."""
    module = importlib.import_module(f"lagrangian_ff.nodes.{node}")
    link = importlib.import_module("lagrangian_ff.nodes.feedforward_link")
    kept = Declarations()
    more = len(inspect.signature(module.declare).parameters) - 1
    if "profiles=True" in inspect.getsource(module):
        kept.declare("profile", "", "name of a file in config/arms, or a path", read_only=True)
    module.declare(kept, *(lambda value: "" for _ in range(more)))
    joints = {"watchdog": module, "feedforward": link}.get(node)
    if joints is not None:
        joints.declare_joints(kept, ("JOINT",))
    if node in ("identify", "monitor"):
        shared = importlib.import_module("lagrangian_ff.nodes.common.node").Parameters
        shared.declare_effort(kept, ("JOINT",))
    names = re.compile(r"joint_[1-6]\b")
    plain = [
        one._replace(
            name=names.sub("JOINT", one.name),
            description=names.sub("JOINT", one.description) if "JOINT" not in one.name else one[2],
        )
        if names.search(one.name)
        else one
        for one in kept.found
    ]
    return list({one.name: one for one in plain}.values())


def cell(value: object) -> str:
    """Return a text for a cell of a table."""
    return re.sub(r"([|~*<])", r"\\\1", str(value))


def code(value: object) -> str:
    """Return code for a cell of a table."""
    text = json.dumps(value, ensure_ascii=False) if not isinstance(value, str) else value or '""'
    return f"`{text}`".replace("|", r"\|")


def table(heading: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return a table in Markdown."""
    lines = [heading, ["---"] * len(heading), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def index(
    title: str,
    text: str,
    heading: Sequence[str],
    names: Sequence[str],
    about: Sequence[str],
    folder: str,
) -> str:
    """Return a page that lists the pages of a folder."""
    rows = [[f"[{n}]({folder}/{n}.md)", cell(a)] for n, a in zip(names, about, strict=True)]
    pages = "\n".join(f"{folder}/{name}" for name in names)
    listed = f"```{{toctree}}\n:hidden:\n\n{pages}\n```"
    return "\n\n".join([f"# {title}", text, table(heading, rows), listed])


def subparsers() -> dict[str, argparse.ArgumentParser]:
    """Return the parser of each command."""
    from lagrangian_ff.cli.main import build_parser

    actions = build_parser()._subparsers
    assert actions is not None
    (group,) = actions._group_actions
    assert isinstance(group.choices, dict)
    return group.choices


def option(action: argparse.Action) -> str:
    """Return an argument with its meaning as an item of a list of definitions."""
    value = (
        ""
        if action.nargs == 0
        else argparse.HelpFormatter("")._format_args(
            action, action.metavar if isinstance(action.metavar, str) else _metavar(action)
        )
    )
    names = [f"`{f'{name} {value}'.strip()}`" for name in action.option_strings] or [f"`{value}`"]
    help_ = (action.help or "") % {**vars(action), "prog": ""}
    return f"{', '.join(names)}\n: {cell(' '.join(help_.split()))}"


def _metavar(action: argparse.Action) -> str:
    if action.choices:
        return "{" + ",".join(map(str, action.choices)) + "}"
    return action.dest.upper() if action.option_strings else action.dest


def command_page(name: str, parser: argparse.ArgumentParser, summary: str) -> str:
    """Return the page of a command."""
    parts = [
        f"# {name}",
        f"{summary[:1].upper()}{summary[1:]}.",
        f"```text\n{parser.usage}\n```",
        parser.description or "",
    ]
    for group in parser._action_groups:
        actions = [a for a in group._group_actions if a.help != argparse.SUPPRESS]
        if actions:
            title = (group.title or "").strip()
            parts += [f"## {title[:1].upper()}{title[1:]}", *map(option, actions)]
    epilog = (parser.epilog or "").strip()
    return "\n\n".join(
        [*parts, *(["## Examples and output", f"```text\n{epilog}\n```"] * bool(epilog))]
    )


def command_pages() -> Iterator[tuple[str, str]]:
    """Yield the pages of all commands, and the list of them."""
    from lagrangian_ff.cli.commands import COMMANDS

    parsers = subparsers()
    for command in COMMANDS:
        yield (
            f"commands/{command.NAME}.md",
            command_page(command.NAME, parsers[command.NAME], command.SUMMARY),
        )
    names, about = [c.NAME for c in COMMANDS], [c.SUMMARY for c in COMMANDS]
    text = (
        "`lagrangian_ff COMMAND --help` says the same in a shell. Exit codes: 0 done, 2 a mistake"
        " that you can fix, 130 interrupted."
    )
    heading = ["command", "what it does"]
    yield "commands.md", index("The command line", text, heading, names, about, "commands")


def node_pages() -> Iterator[tuple[str, str]]:
    """Yield the pages of all nodes, and the list of them."""
    first = []
    for node in NODES:
        text = inspect.getdoc(importlib.import_module(f"lagrangian_ff.nodes.{node}")) or ""
        first.append(text.partition("\n")[0])
        listed = [
            [code(one.name), code(one.default), cell(one.description), cell(one.allowed), one.when]
            for one in parameters(node)
        ]
        told = table(["parameter", "default", "meaning", "allowed", "set"], listed)
        yield f"nodes/{node}.md", f"# {node}\n\n```text\n{text}\n```\n\n## Parameters\n\n{told}"
    text = (
        "As the nodes declare them. [The nodes](../nodes.md) says how to use them; `config/` has a"
        " file of parameters for each."
    )
    heading = ["node", "what it does"]
    yield "nodes.md", index("Parameters of the nodes", text, heading, NODES, first, "nodes")


def about(room: ModuleType, name: str) -> str:
    """Return the text below the assignment of a constant that a room offers, "" without one."""
    source = Path(str(room.__file__))
    stub = source.with_suffix(".pyi")
    listed = ast.parse((stub if stub.exists() else source).read_text(encoding="utf-8"))
    for node in listed.body:
        if isinstance(node, ast.ImportFrom) and name in [alias.name for alias in node.names]:
            source = Path(str(importlib.import_module(str(node.module)).__file__))
    body = ast.parse(source.read_text(encoding="utf-8")).body
    for node, below in pairwise(body):
        target = node.target if isinstance(node, ast.AnnAssign) else None
        targets = node.targets if isinstance(node, ast.Assign) else [target]
        named = any(isinstance(one, ast.Name) and one.id == name for one in targets)
        if named and isinstance(below, ast.Expr) and isinstance(below.value, ast.Constant):
            return str(below.value.value)
    return ""


def python_pages() -> Iterator[tuple[str, str]]:
    """Yield the pages of the rooms' public names, and the list of them."""
    first = []
    for room in ROOMS:
        module = importlib.import_module(f"lagrangian_ff.{room}")
        text = (inspect.getdoc(module) or "").partition("\n")[0]
        first.append(text)
        parts = [f"# lagrangian_ff.{room}", text]
        for name in module.__all__:
            thing, path = getattr(module, name), f"lagrangian_ff.{room}.{name}"
            if inspect.isclass(thing):
                body = f".. autoclass:: {path}\n   :members:"
            elif inspect.isfunction(thing):
                body = f".. autofunction:: {path}"
            else:
                body = f".. py:data:: {path}\n\n   {' '.join(about(module, name).split())}"
            parts.append(f"```{{eval-rst}}\n{body}\n```")
        yield f"python/{room}.md", "\n\n".join(parts)
    text = (
        "The public names of `lagrangian_ff`, with shapes and units. [From Python](../python.md)"
        " has a first session."
    )
    heading = ["package", "what is in it"]
    yield "python.md", index("Python", text, heading, ROOMS, first, "python")


def schema_page() -> str:
    """Return the page of the schema of exported models."""
    schema = json.loads(SCHEMA.read_text(encoding="utf-8"))
    needed = schema.get("required", [])
    rows = [
        [code(name), cell(about.get("description", "")), "yes" if name in needed else ""]
        for name, about in schema["properties"].items()
    ]
    return (
        "# The exported model as JSON\n\n"
        f"{schema.get('description', '')} [Exports](../export.md) says how to use it.\n\n"
        f"{table(['field', 'meaning', 'required'], rows)}\n\n## The schema\n\n"
        "```{literalinclude} ../../lagrangian_ff/export/model.schema.json\n:language: json\n```"
    )


def write(folder: Path) -> None:
    """Write all pages into a folder; what is as it was is not touched."""
    pages = {**dict(command_pages()), **dict(node_pages()), **dict(python_pages())}
    pages["schema.md"] = schema_page()
    for name, text in pages.items():
        page = folder / name
        page.parent.mkdir(parents=True, exist_ok=True)
        if not page.exists() or page.read_text(encoding="utf-8") != text + "\n":
            page.write_text(text + "\n", encoding="utf-8")
    for page in folder.rglob("*.md"):
        if str(page.relative_to(folder)) not in pages:
            page.unlink()


if __name__ == "__main__":
    write(Path(sys.argv[1]))
