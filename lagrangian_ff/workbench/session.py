"""A session on disk: recordings and what each is for, models as a tree, and what was found of them.

`session.json` is written whole after every change, so that a killed server loses nothing.
"""

import json
import shutil
from dataclasses import asdict, dataclass, field
from enum import Enum
from pathlib import Path
from typing import Any

from lagrangian_ff.errors import UserError
from lagrangian_ff.files import whole
from lagrangian_ff.record_json import finite
from lagrangian_ff.recording.motion import TOTAL
from lagrangian_ff.workbench.settings import AUTO, URDF, Reading, choices, model_name

VERSION = 1
FILE = "session.json"


class Role(str, Enum):
    """What a recording is used for; JSON holds the value."""

    LEARN = "learn"
    SEARCH = "search"
    CONFIRM = "confirm"
    ASIDE = "aside"


@dataclass
class Card:
    """A recording.

    Attributes:
        id: names it in the page.
        name: as the user knows it.
        file: where it lies.
        role: what it is used for.
        looked: what it holds, see `looking.Look`; None before it was read.
        error: why it cannot be used; empty if it can.
        scale: by joint, N·m per unit of effort where a remedy changed it.
        observed: which effects it could show, see `looking.Observe`; None before.
        unobserved: why that is not known; empty if it is, or will be.
    """

    id: str
    name: str
    file: str
    role: Role = Role.ASIDE
    looked: dict[str, Any] | None = None
    error: str = ""
    scale: dict[str, float] = field(default_factory=dict)
    observed: dict[str, Any] | None = None
    unobserved: str = ""


@dataclass
class Node:
    """A model, and what is known of it.

    Attributes:
        id: names it in the page.
        file: of the model.
        parent: the model it came from; empty for one that was identified.
        title: what was done, in words.
        described: see `jobs.described`.
        compared: see `jobs.Compare`; None before.
        on: the recordings that it was compared with.
        diagnosed: see `jobs.Search`; None before.
        what_if: see `jobs.WhatIf`; None before.
        proposed: by joint, formulas for what nobody listed, see `jobs.Propose`.
        added: `effect` and `joint` of what was added, with the `form` of a curve and the `shape`
            of a proposed formula; empty for a model that was identified.
        why: the evidence for the effect that was added, as the model's history has it.
        settings: how it, or the model it came from, was learned, see `Session.chosen`; of one that
            was investigated `learned` and `stretch`, too, see `learned_and_unseen`.
    """

    id: str
    file: str
    parent: str
    title: str
    described: dict[str, Any]
    compared: dict[str, Any] | None = None
    on: tuple[str, ...] = ()
    diagnosed: dict[str, Any] | None = None
    what_if: dict[str, Any] | None = None
    proposed: dict[str, Any] = field(default_factory=dict)
    added: dict[str, Any] = field(default_factory=dict)
    why: dict[str, Any] = field(default_factory=dict)
    settings: dict[str, Any] = field(default_factory=dict)


@dataclass
class Session:
    """All that a page shows; every change is on disk when a method returns.

    Attributes:
        folder: of the session.
        cards: recordings, in the order in which they came.
        nodes: models, in the order in which they were made.
        current: the model that is looked at; empty without one.
        formulas: effects of the user's own, as `effects.formula` reads them.
        motions: those to record next, see `moving.Move`, each with `id`, `title` and `file`.
        investigations: see `investigations`, each with `id`, `steps`, `ended` and its `story`.
        effort: what the effort of all recordings holds.
        effort_delay: s by which it comes later than the position.
        choice: the model to learn, one of `settings.choices`.
        undone: models that `redo` goes back to, the next one last.
        count: how many things were named, so that no name comes twice.
        version: grows with each change; the page asks for what is newer.
        urdf: the file of the arm's description, given anew each time; empty for none.
    """

    folder: Path
    cards: list[Card] = field(default_factory=list)
    nodes: list[Node] = field(default_factory=list)
    current: str = ""
    formulas: list[dict[str, Any]] = field(default_factory=list)
    motions: list[dict[str, Any]] = field(default_factory=list)
    investigations: list[dict[str, Any]] = field(default_factory=list)
    effort: str = TOTAL
    effort_delay: float = 0.0
    choice: str = AUTO
    undone: list[str] = field(default_factory=list)
    count: int = 0
    version: int = 0
    urdf: str = ""

    @classmethod
    def open(cls, folder: Path) -> "Session":
        """Return the session in a folder, a new one if there is none.

        Raises:
            UserError: the folder cannot be written, or holds a session that cannot be read.
        """
        session = cls(folder)
        try:
            folder.mkdir(parents=True, exist_ok=True)
            if (folder / FILE).exists():
                session._take(json.loads((folder / FILE).read_text(encoding="utf-8")))
            session.save()
        except OSError as error:
            raise UserError(f"{folder}: cannot be used: {error.strerror or error}") from error
        except (ValueError, KeyError, TypeError) as error:
            raise UserError(
                f"{folder / FILE}: no session of this version ({error}); name another folder"
            ) from error
        return session

    def _take(self, saved: dict[str, Any]) -> None:
        if saved["format"] != VERSION:
            raise ValueError(f"format {saved['format']}")
        self.cards = [Card(**{**one, "role": Role(one["role"])}) for one in saved["cards"]]
        self.nodes = [Node(**{**one, "on": tuple(one["on"])}) for one in saved["nodes"]]
        self.current, self.undone = saved["current"], list(saved["undone"])
        self.formulas, self.motions = saved["formulas"], saved.get("motions", [])
        self.investigations = saved.get("investigations", [])
        self.effort, self.choice = saved.get("effort", TOTAL), saved.get("choice", AUTO)
        self.effort_delay = saved.get("effort_delay", 0.0)
        self.count, self.version = saved["count"], saved["version"]

    def save(self) -> None:
        """Write what has changed."""
        self.version += 1
        with whole(self.folder / FILE) as made:
            made.write_text(json.dumps(self.record(), ensure_ascii=False), encoding="utf-8")

    def record(self) -> dict[str, Any]:
        """Return the session for JSON."""
        return finite({
            "format": VERSION,
            "cards": [{**asdict(one), "role": one.role.value} for one in self.cards],
            "nodes": [asdict(one) for one in self.nodes],
            "current": self.current,
            "formulas": self.formulas,
            "motions": self.motions,
            "investigations": self.investigations,
            "effort": self.effort,
            "effort_delay": self.effort_delay,
            "choice": self.choice,
            "undone": self.undone,
            "count": self.count,
            "version": self.version,
        })  # fmt: skip

    def add_formula(self, formula: dict[str, Any]) -> None:
        """Take an effect of the user's own; one of the same name goes."""
        self.formulas = [one for one in self.formulas if one["name"] != formula["name"]]
        self.formulas.append(formula)
        with whole(self.effects) as made:
            made.write_text(json.dumps({"effects": self.formulas}), encoding="utf-8")
        self.save()

    def motion(self, identity: str) -> dict[str, Any]:
        """Return a motion by its name in the page.

        Raises:
            UserError: there is none.
        """
        found = next((one for one in self.motions if one["id"] == identity), None)
        if found is None:
            raise UserError("this motion is no longer there; reload the page")
        return found

    @property
    def effects(self) -> Path:
        """Return the file of the user's formulas."""
        return self.folder / "formulas.json"

    def name(self, letter: str) -> str:
        """Return a name that was not there before."""
        self.count += 1
        return f"{letter}{self.count}"

    def card(self, identity: str) -> Card:
        """Return a recording by its name in the page.

        Raises:
            UserError: there is none.
        """
        found = next((one for one in self.cards if one.id == identity), None)
        if found is None:
            raise UserError("this recording is no longer there; reload the page")
        return found

    def node(self, identity: str = "") -> Node:
        """Return a model by its name in the page, or the one that is looked at.

        Raises:
            UserError: there is none.
        """
        wanted = identity or self.current
        found = next((one for one in self.nodes if one.id == wanted), None)
        if found is None:
            raise UserError("there is no model yet: learn one first")
        return found

    def add_card(self, name: str, file: Path) -> Card:
        """Take a recording; the first is to be learned from, the others confirm."""
        roles = {one.role for one in self.cards}
        wanted = (Role.LEARN, Role.SEARCH, Role.CONFIRM)
        role = next((one for one in wanted if one not in roles), Role.CONFIRM)
        card = Card(self.name("r"), name, str(file), role)
        self.cards.append(card)
        self.save()
        return card

    def remove_card(self, identity: str) -> None:
        """Forget a recording; its file goes if it lies in the session."""
        card = self.card(identity)
        self.cards.remove(card)
        self.save()
        place = self.folder / "recordings" / card.id
        if place in Path(card.file).parents or place == Path(card.file):
            shutil.rmtree(place, ignore_errors=True)

    def files(self, *roles: Role) -> tuple[str, ...]:
        """Return the files of the usable recordings with these roles."""
        usable = (one for one in self.cards if not one.error and one.looked is not None)
        return tuple(one.file for one in usable if one.role in roles)

    @property
    def reading(self) -> Reading:
        """Return how the recordings are read."""
        scales = {one.file: one.scale for one in self.cards if one.scale}
        return Reading(self.effort, self.effort_delay, scales)

    def chosen(self, files: tuple[str, ...]) -> dict[str, Any]:
        """Return how a model is learned from files now.

        Returns:
            `model`, its name; `asked`, the same where it is not the usual; `urdf`, whose bodies it
            takes, empty for none; and the `Reading.record` of the files.
        """
        known = self.choice in [one.name for one in choices(self.urdf)]
        choice = self.choice if known else AUTO  # the description is no longer given
        name = model_name(choice, self.effort)
        return {
            "model": name,
            "asked": "" if choice in (AUTO, URDF) else name,
            "urdf": self.urdf if choice == URDF else "",
            **self.reading.record(files),
        }

    def choose(self, choice: str) -> None:
        """Choose the model to learn.

        Raises:
            UserError: there is none of this name.
        """
        if choice not in [one.name for one in choices(self.urdf)]:
            raise UserError(f"there is no model {choice!r} to choose")
        self.choice = choice
        self.save()

    def derived(self) -> dict[str, Any]:
        """Return what a page shows besides what is saved.

        Returns:
            `choices` of models; `outdated`, names of the models whose recordings are read in
            another way now.
        """
        scales = {card.file: card.scale for card in self.cards}
        outdated = [
            node.id
            for node in self.nodes
            if node.settings
            if node.settings["effort"] != self.effort
            or node.settings.get("effort_delay", 0.0) != self.effort_delay
            or any(scales.get(f, one) != one for f, one in node.settings["scales"].items())
        ]
        return {"choices": [asdict(one) for one in choices(self.urdf)], "outdated": outdated}

    def unseen(self) -> tuple[str, ...]:
        """Return the recordings that no model learns from: those that confirm, else those searched,
        else those learned from."""
        choices = ([Role.CONFIRM], [Role.SEARCH], [Role.LEARN])
        return next((files for one in choices if (files := self.files(*one))), ())

    def add_node(self, node: Node) -> None:
        """Take a model, and look at it."""
        self.nodes.append(node)
        self.current, self.undone = node.id, []
        self.save()

    def undo(self) -> None:
        """Look at the model that this one came from.

        Raises:
            UserError: it came from none.
        """
        node = self.node()
        if not node.parent:
            raise UserError("there is nothing to undo: this model came from no other")
        self.undone.append(node.id)
        self.current = node.parent
        self.save()

    def redo(self) -> None:
        """Look again at the model that was left last.

        Raises:
            UserError: none was.
        """
        if not self.undone:
            raise UserError("there is nothing to do again")
        self.current = self.undone.pop()
        self.save()

    def look_at(self, identity: str) -> None:
        """Look at another model."""
        self.current, self.undone = self.node(identity).id, []
        self.save()
