"""What is known of a measured arm: the file that says so, checked and as types."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from hashlib import sha256
from math import isfinite, radians
from pathlib import Path
from typing import Any

from lagrangian_ff.effects import EFFECTS
from lagrangian_ff.errors import UserError
from lagrangian_ff.studies.measured.kinematics import MODIFIED, STANDARD, Kinematics, Row

FILE = "known.json"
QUANTITIES = ("time", "position", "velocity", "effort")
Column = str | int
"""A column by the name in the header, or by its number from 0."""


@dataclass(frozen=True)
class Layout:
    """Where the quantities of a recording stand that is in no format of this package.

    Attributes:
        variable: the struct of a MATLAB file that holds them; empty for none.
        columns: by quantity: a column for each joint, or one name of a table for all of them.
        effort_minus: columns that are taken off the effort, such as torque that was injected.
        degrees: positions and velocities are in degrees.
        effort_scale: N·m per unit of effort, for each joint; empty is 1.
    """

    variable: str = ""
    columns: Mapping[str, tuple[Column, ...]] | None = None
    effort_minus: tuple[Column, ...] = ()
    degrees: bool = False
    effort_scale: tuple[float, ...] = ()


@dataclass(frozen=True)
class Source:
    """A recording.

    Attributes:
        name: unique in the arm.
        files: by quantity, where each stands in a file of its own; or one under the empty name.
        layout: of the files; None for the formats of this package.
        samples: first and last (not included) that count; None is the end.
    """

    name: str
    files: Mapping[str, Path]
    layout: Layout
    samples: tuple[int, int | None] = (0, None)


@dataclass(frozen=True)
class Part:
    """A part of a recording, from one share of its time to another."""

    recording: str
    share: tuple[float, float] = (0.0, 1.0)


@dataclass(frozen=True)
class Split:
    """A use of the recordings.

    Attributes:
        name: unique in the arm.
        train: what models learn from.  test: what they are judged on.
        search: what the diagnosis searches.  confirm: what confirms its findings.
    """

    name: str
    train: tuple[Part, ...]
    test: tuple[Part, ...]
    search: tuple[Part, ...]
    confirm: tuple[Part, ...]


@dataclass(frozen=True)
class Expected:
    """Effects that are right on certain joints.

    Attributes:
        effects: names of the catalogue, of which any is meant.
        joints: names; empty is any.
    """

    effects: tuple[str, ...]
    joints: tuple[str, ...] = ()

    def fits(self, effects: Sequence[str], joints: Sequence[str]) -> bool:
        """Return whether one of the effects, on one of the joints, is meant."""
        there = not self.joints or bool(set(self.joints).intersection(joints))
        return there and bool(set(self.effects).intersection(effects))


@dataclass(frozen=True)
class Known:
    """What is known of an arm.

    Attributes:
        name: of the file's arm, for cases; such as `kr300`.
        about: the arm in words.
        joints: N names, from the base to the tool.
        sources: its recordings by name.
        splits: the uses of them.
        kinematics: for the standard way; None if they are not known.
        may: effects that are right if they are named.  must: those that are there.
        contact: columns of torque that was injected, whose pulses are contacts; and N·m above
            which they count.
    """

    name: str
    about: str
    joints: tuple[str, ...]
    sources: Mapping[str, Source]
    splits: tuple[Split, ...]
    kinematics: Kinematics | None = None
    may: tuple[Expected, ...] = ()
    must: tuple[Expected, ...] = ()
    contact: tuple[tuple[Column, ...], float] = ((), 0.0)

    @property
    def used(self) -> str:
        """Return a digest of what results depend on: all but what is right, and words."""
        held = self.joints, self.sources, self.splits, self.kinematics, self.contact
        return sha256(repr(held).encode()).hexdigest()[:12]


def known_arms(folder: Path, known: Path | None = None) -> list[Known]:
    """Return what is known of the arms whose recordings are in a folder.

    Args:
        folder: of the recordings.
        known: a folder of files NAME.json; None reads every known.json below `folder`.

    Raises:
        UserError: there are none, one cannot be read, or one is not right; names file and field.
    """
    for each, option in ((folder, "FOLDER"), (known, "--known")):
        if each is not None and not each.is_dir():
            raise UserError(f"{option} {each}: no such folder")
    paths = sorted(known.glob("*.json") if known else folder.rglob(FILE))
    if not paths:
        where = f"{known}: holds no *.json" if known else f"{folder}: holds no {FILE}"
        raise UserError(
            f"{where}, which says what is known of the recordings (docs/studies.md has its form); "
            "name the folder that has such files with --known"
        )
    arms = [_Reader(path, folder if known else path.parent).known() for path in paths]
    names = [arm.name for arm in arms]
    twice = {name for name in names if names.count(name) > 1}
    if twice:
        raise UserError(f"the arm {', '.join(sorted(twice))} is described twice below {folder}")
    return arms


@dataclass(frozen=True)
class _Reader:
    """Reads one file; every error names it and the field.

    Attributes:
        path: of the file.  root: the folder that paths in it are relative to.
    """

    path: Path
    root: Path

    def known(self) -> Known:
        """Return the file's contents."""
        try:
            held = json.loads(self.path.read_text(encoding="utf-8"))
        except (OSError, UnicodeDecodeError, json.JSONDecodeError) as error:
            raise UserError(f"{self.path}: cannot be read: {error}") from error
        names = ("name", "about", "joints", "read", "recordings", "splits", "kinematics")
        fields = self.fields(held, "the file", (*names, "may", "must", "contact"))
        joints = self.texts(fields.get("joints"), "joints")
        layout = self.layout(fields.get("read"), "read", len(joints), Layout())
        recordings = self.mapping(fields.get("recordings"), "recordings")
        sources = {
            name: self.source(name, value, len(joints), layout)
            for name, value in recordings.items()
        }
        splits = self.mapping(fields.get("splits"), "splits")
        default = self.path.stem if self.path.name != FILE else self.path.parent.name
        return Known(
            name=str(fields.get("name", default)),
            about=str(fields.get("about", "")),
            joints=joints,
            sources=sources,
            splits=tuple(self.split(name, one, sources) for name, one in splits.items()),
            kinematics=self.kinematics(fields.get("kinematics"), len(joints)),
            may=self.expected(fields.get("may"), "may", joints),
            must=self.expected(fields.get("must"), "must", joints),
            contact=self.contact(fields.get("contact")),
        )

    def wrong(self, where: str, expected: str, found: object) -> UserError:
        """Return the error of a field."""
        return UserError(f"{self.path}: {where} is {found!r}, expected {expected}")

    def fields(self, value: object, where: str, known: Sequence[str]) -> Mapping[str, Any]:
        """Return a mapping that has known fields only."""
        held = self.mapping(value, where)
        strange = [name for name in held if name not in known]
        if strange:
            raise UserError(
                f"{self.path}: {where} has {', '.join(strange)}; it may have {', '.join(known)}"
            )
        return held

    def mapping(self, value: object, where: str) -> Mapping[str, Any]:
        """Return a mapping that is not empty."""
        if not isinstance(value, dict) or not value:
            raise self.wrong(where, "names with values", value)
        return value

    def texts(self, value: object, where: str) -> tuple[str, ...]:
        """Return names."""
        if not isinstance(value, list) or not value or not all(isinstance(v, str) for v in value):
            raise self.wrong(where, "a list of names", value)
        return tuple(value)

    def number(self, value: object, where: str) -> float:
        """Return a finite number."""
        right = isinstance(value, int | float) and not isinstance(value, bool)
        if not right or not isfinite(value):  # type: ignore[arg-type]
            raise self.wrong(where, "a number", value)
        return float(value)  # type: ignore[arg-type]

    def numbers(self, value: object, where: str, count: int) -> tuple[float, ...]:
        """Return so many numbers."""
        if not isinstance(value, list) or len(value) != count:
            raise self.wrong(where, f"{count} numbers", value)
        return tuple(self.number(one, where) for one in value)

    def columns(self, value: object, where: str, count: int) -> tuple[Column, ...]:
        """Return one column for each joint, or the one table that holds all."""
        one = isinstance(value, str | int) and not isinstance(value, bool)
        listed = [value] if one else value
        if not isinstance(listed, list) or len(listed) not in (1, count):
            raise self.wrong(where, f"{count} columns by name or number, or one table", value)
        return tuple(listed)

    def layout(self, value: object, where: str, joints: int, usual: Layout) -> Layout:
        """Return a layout; what is not said is as usual."""
        if value is None:
            return usual
        names = ("variable", "effort_minus", "degrees", "effort_scale", *QUANTITIES)
        held = self.fields(value, where, names)
        columns = {
            name: self.columns(held[name], f"{where} {name}", 1 if name == "time" else joints)
            for name in QUANTITIES
            if name in held
        }
        minus = held.get("effort_minus")
        scale = held.get("effort_scale")
        return Layout(
            variable=str(held.get("variable", usual.variable)),
            columns={**(usual.columns or {}), **columns} or None,
            effort_minus=usual.effort_minus
            if minus is None
            else self.columns(minus, f"{where} effort_minus", joints),
            degrees=bool(held.get("degrees", usual.degrees)),
            effort_scale=usual.effort_scale
            if scale is None
            else self.numbers(scale, f"{where} effort_scale", joints),
        )

    def source(self, name: str, value: object, joints: int, usual: Layout) -> Source:
        """Return a recording: a file, files by quantity, or either with more fields."""
        where = f"recording {name}"
        held = {"file": value} if isinstance(value, str) else value
        held = self.fields(held, where, ("file", "read", "samples"))
        files = held.get("file")
        if isinstance(files, str):
            files = {"": files}
        files = self.mapping(files, f"{where} file")
        if "" not in files:
            self.fields(files, f"{where} file", QUANTITIES)
        samples = held.get("samples", [0, None])
        if not isinstance(samples, list) or len(samples) != 2:
            raise self.wrong(f"{where} samples", "the first and the last, or null", samples)
        layout = self.layout(held.get("read"), f"{where} read", joints, usual)
        paths = {quantity: self.root / str(path) for quantity, path in files.items()}
        return Source(name, paths, layout, (int(samples[0]), samples[1]))

    def split(self, name: str, value: object, sources: Mapping[str, Source]) -> Split:
        """Return a use of the recordings."""
        held = self.fields(value, f"split {name}", ("train", "test", "search", "confirm"))
        parts = {
            use: tuple(self.part(one, f"split {name} {use}", sources) for one in held[use])
            for use in held
        }
        for use in ("train", "test"):
            if not parts.get(use):
                raise self.wrong(f"split {name} {use}", "recordings", held.get(use))
        search = parts.get("search", parts["train"])
        return Split(name, parts["train"], parts["test"], search, parts.get("confirm", ()))

    def part(self, value: object, where: str, sources: Mapping[str, Source]) -> Part:
        """Return a part of a recording: its name, or its name and a share."""
        held = {"recording": value} if isinstance(value, str) else value
        held = self.fields(held, where, ("recording", "share"))
        name = held.get("recording")
        if name not in sources:
            raise self.wrong(where, f"one of {', '.join(sources)}", name)
        first, last = self.numbers(held.get("share", [0.0, 1.0]), f"{where} share", 2)
        if not 0.0 <= first < last <= 1.0:
            raise self.wrong(f"{where} share", "two shares of the time, 0 to 1", [first, last])
        return Part(str(name), (first, last))

    def kinematics(self, value: object, joints: int) -> Kinematics | None:
        """Return the kinematics."""
        if value is None:
            return None
        names = ("source", "urdf", "convention", "rows", "gravity")
        held = self.fields(value, "kinematics", names)
        source = str(held.get("source", self.path))
        usual = list(Kinematics.gravity)
        gravity = self.numbers(held.get("gravity", usual), "kinematics gravity", 3)
        if "urdf" in held:
            return Kinematics(source, self.root / str(held["urdf"]), gravity=gravity)
        convention = held.get("convention")
        if convention not in (STANDARD, MODIFIED):
            raise self.wrong("kinematics convention", f"{STANDARD} or {MODIFIED}", convention)
        rows = held.get("rows")
        if not isinstance(rows, list) or len(rows) != joints:
            raise self.wrong("kinematics rows", f"one for each of the {joints} joints", rows)
        made = tuple(self.row(one, f"kinematics row {k}") for k, one in enumerate(rows, 1))
        return Kinematics(source, None, convention, made, gravity)

    def row(self, value: object, where: str) -> Row:
        """Return a row; angles are in degrees in the file."""
        names = ("a", "d", "alpha", "theta", "mass", "centre")
        held = self.fields(value, where, names)
        a, d, alpha, theta = (self.number(held.get(name, 0.0), where) for name in names[:4])
        mass = self.number(held["mass"], f"{where} mass") if "mass" in held else None
        centre = self.numbers(held["centre"], f"{where} centre", 3) if "centre" in held else None
        return Row(a, d, radians(alpha), radians(theta), mass, centre)

    def expected(self, value: object, where: str, joints: Sequence[str]) -> tuple[Expected, ...]:
        """Return effects that are right."""
        found = []
        for one in value if isinstance(value, list) else [] if value is None else [value]:
            held = self.fields(one, where, ("effects", "joints", "source"))
            effects = self.texts(held.get("effects"), f"{where} effects")
            strange = [name for name in effects if name not in EFFECTS]
            if strange:
                raise self.wrong(f"{where} effects", f"some of {', '.join(EFFECTS)}", strange)
            there = self.texts(held["joints"], f"{where} joints") if "joints" in held else ()
            if not set(there) <= set(joints):
                raise self.wrong(f"{where} joints", f"some of {', '.join(joints)}", there)
            found.append(Expected(effects, there))
        return tuple(found)

    def contact(self, value: object) -> tuple[tuple[Column, ...], float]:
        """Return the columns of injected torque, and what counts as a pulse."""
        if value is None:
            return (), 0.0
        held = self.fields(value, "contact", ("columns", "above"))
        columns = self.texts(held.get("columns"), "contact columns")
        return columns, self.number(held.get("above"), "contact above")
