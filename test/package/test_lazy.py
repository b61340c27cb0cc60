"""Packages whose names are imported when they are first asked for."""

from __future__ import annotations

import ast
import importlib
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
STUBS = sorted((ROOT / "lagrangian_ff").rglob("__init__.pyi"))


def dotted(stub: Path) -> str:
    """Return the name of the package that a stub lists."""
    return ".".join(stub.relative_to(ROOT).parts[:-1])


@pytest.mark.parametrize("stub", STUBS, ids=dotted)
def test_the_package_has_what_its_stub_lists_and_nothing_else(stub: Path) -> None:
    if stub.parent.name == "arm":
        pytest.importorskip("pybullet", reason="PyBullet is not installed")
    room = importlib.import_module(dotted(stub))
    imports = [
        node for node in ast.parse(stub.read_text()).body if isinstance(node, ast.ImportFrom)
    ]
    names = {alias.asname: node.module for node in imports for alias in node.names}
    assert names
    for name, module in names.items():
        assert name is not None, "a stub exports what is imported as itself"
        assert module is not None
        assert getattr(room, name) is getattr(importlib.import_module(module), name)
    assert sorted(room.__all__) == sorted(map(str, names))
    with pytest.raises(AttributeError, match="no attribute 'no_such_name'"):
        room.no_such_name  # noqa: B018


@pytest.mark.parametrize("stub", STUBS, ids=dotted)
def test_no_name_is_that_of_a_file_beside_it(stub: Path) -> None:
    beside = {path.stem for path in stub.parent.iterdir()} - {"__init__"}
    names = set(importlib.import_module(dotted(stub)).__all__)
    assert not names & beside, "Python would put the file in the name's place"
