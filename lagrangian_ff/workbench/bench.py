"""Does what the page asks: it changes the session and starts work in processes."""

import shutil
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from lagrangian_ff.errors import UserError
from lagrangian_ff.workbench import jobs
from lagrangian_ff.workbench.investigating import Arm, Investigate
from lagrangian_ff.workbench.investigations import Investigations
from lagrangian_ff.workbench.looking import Look
from lagrangian_ff.workbench.moving import Move
from lagrangian_ff.workbench.recordings import Asked, Recordings
from lagrangian_ff.workbench.session import Card, Node, Role, Session
from lagrangian_ff.workbench.unlisted import Unlisted
from lagrangian_ff.worker import Outcome, Worker

CURVE = "curve"
"""Under which name `diagnosis.add` adds one."""


@dataclass
class Running:
    """Work under way.

    Attributes:
        id: names it in the page.
        title: in words.
        worker: its process.
        take: receives what came out.
        failed: receives the error in words.
    """

    id: str
    title: str
    worker: Worker[Any]
    take: Callable[[Any], None]
    failed: Callable[[str], None]


class Bench:
    """A session and the work on it.

    Args:
        session: on disk.
        changed: is called after every change that pages show.
        skeleton: of the arm, see `skeleton.read_skeleton`.
        arm: that may be investigated; None for none.

    Attributes:
        investigations: of the session.
        more: returns what pages show besides.
    """

    def __init__(
        self,
        session: Session,
        changed: Callable[[], None],
        skeleton: Sequence[dict[str, Any]] = (),
        arm: Arm | None = None,
    ) -> None:
        self.session = session
        self._skeleton = list(skeleton)
        self._recordings = Recordings(session, self._begin)
        self.investigations = Investigations(
            session, self._begin, self._recordings.look, self._compare, arm
        )
        unlisted = Unlisted(session, self._begin, self._add_to)
        self.more: Callable[[], dict[str, Any]] = dict
        self._changed = changed
        self._running: list[Running] = []
        self._waiting: list[Callable[[], None]] = []
        self._said = ""
        self._asks: dict[str, Callable[[Asked], Asked | None]] = {
            **self._recordings.asks,
            **self.investigations.asks,
            **unlisted.asks,
            "read": self._read,
            "choose": lambda asked: session.choose(str(asked["model"])),
            "learn": self._learn,
            "diagnose": self._diagnose,
            "whatif": self._what_if,
            "add": self._add,
            "formula": self._formula,
            "move": self._move,
            "undo": lambda asked: self._then(self.session.undo),
            "redo": lambda asked: self._then(self.session.redo),
            "look": lambda asked: self._then(lambda: self.session.look_at(str(asked["model"]))),
            "cancel": self._cancel,
        }
        self._recordings.begin()

    def progress(self) -> dict[str, Any]:
        """Return the work under way, and what went wrong with the last."""
        work = [
            {
                "id": one.id,
                "title": one.title,
                "share": one.worker.fraction,
                "label": one.worker.label,
                "stops": isinstance(one.worker.job, Investigate),
            }
            for one in self._running
        ]
        arm = self.investigations.state()
        return {"work": work, "said": self._said, "arm": arm, **self.more()}

    def state(self) -> dict[str, Any]:
        """Return all that a page shows."""
        return {
            **self.session.record(),
            **self.session.derived(),
            **self.progress(),
            "skeleton": self._skeleton,
        }

    def ask(self, what: str, asked: Asked) -> Asked:
        """Do what a page asks, and return what it is to know.

        Raises:
            UserError: it is not possible now, and why.
        """
        if what not in self._asks:
            raise UserError(f"the page asks for {what!r}, which is not known; reload it")
        self._said = ""
        try:
            found = self._asks[what](asked)
        except (KeyError, ValueError, TypeError) as error:
            raise UserError(f"the page asks for {what} in an unknown way: {error}") from error
        self._changed()
        return found or {}

    def take_file(self, name: str, file: Path) -> Card:
        """Take a recording that lies somewhere already."""
        card = self.session.add_card(name, file)
        self._recordings.look(card)
        self._changed()
        return card

    def take_upload(self, name: str, uploaded: Path) -> Card:
        """Take a file that a page sent; it moves into the session.

        The name is only shown: the file is called by what kind it is.
        """
        card = self.session.add_card(name, uploaded)
        suffixes = "".join(s for s in Path(name).suffixes[-2:] if s[1:].isalnum() and len(s) < 8)
        place = self.session.folder / "recordings" / card.id
        place.mkdir(parents=True)
        card.file = str(place / f"recording{suffixes.lower()}")
        shutil.move(uploaded, card.file)
        self.session.save()
        self._recordings.look(card)
        self._changed()
        return card

    def tick(self) -> None:
        """Take what has come out of processes; to be called several times a second."""
        moved = self.investigations.tick()
        for one in list(self._running):
            outcome: Outcome | None = one.worker.outcome()
            if outcome is None:
                continue
            moved = True
            self._running.remove(one)
            if outcome.result is None:
                one.failed(outcome.error)
            else:
                one.take(outcome.result)
        if self._free and self._waiting:
            self._waiting.pop(0)()
            moved = True
        if self._recordings.aside.tick(free=not self._running) or moved or self._running:
            self._changed()

    def close(self) -> None:
        """End the work under way."""
        self._recordings.aside.close()
        for one in self._running:
            one.worker.cancel()
        self._running, self._waiting = [], []

    def _begin(
        self,
        title: str,
        job: Any,
        take: Callable[[Any], None],
        failed: Callable[[str], None] | None = None,
        began: Callable[[Worker[Any]], None] = lambda worker: None,
    ) -> None:
        """Start work in a process, or after the work under way: it has all processors.

        Args:
            began: receives the process.
        """

        def start() -> None:
            self._recordings.aside.give_way()
            told = failed or (lambda error: self._fail(title, error))
            worker = Worker(job)
            self._running.append(Running(self.session.name("w"), title, worker, take, told))
            began(worker)

        if self._free:
            start()
        else:
            self._waiting.append(start)

    @property
    def _free(self) -> bool:
        """Return whether work may begin: beside an investigation, too, which waits for its arm."""
        return all(isinstance(one.worker.job, Investigate) for one in self._running)

    def _fail(self, title: str, error: str) -> None:
        self._said = f"{title} failed: {error}"

    def _then(self, change: Callable[[], None]) -> None:
        change()
        if self.session.node().compared is None:
            self._compare()

    def _read(self, asked: Asked) -> None:
        """Read recordings in another way; what was found on them does not hold any more."""
        files = self._recordings.read(asked)
        outdated = self.session.derived()["outdated"]
        for node in self.session.nodes:
            # A model of other settings is to be learned again: what was found of it stays.
            if node.id not in outdated and files.intersection(node.on):
                node.compared = node.diagnosed = node.what_if = None
        self.session.save()
        if self.session.nodes and self.session.node().compared is None:
            self._waiting.append(self._compare_if_possible)

    def _compare_if_possible(self) -> None:
        with suppress(UserError):
            self._compare()

    def _learn(self, asked: Asked) -> None:
        sources = self.session.files(Role.LEARN)
        if not sources:
            raise UserError("there is nothing to learn from: put a recording under Learn from")
        (identity, file), chosen = self._new_model(), self.session.chosen(sources)
        reading = self.session.reading

        def take(found: Any) -> None:
            self.session.add_node(Node(identity, file, "", "learned", found, settings=chosen))
            self._compare()

        job = jobs.Learn(file, sources, chosen["model"], chosen["urdf"], reading)
        self._begin("learning a model", job, take)

    def _compare(self, model: str = "") -> None:
        """Compare a model with what it has not seen; the one that is looked at if none is named."""
        node, sources = self.session.node(model), self.session.unseen()
        if not sources:
            raise UserError("there is no recording to compare with")
        own = node.settings.get("scales", {}) if "learned" in node.settings else {}
        learned: tuple[float, ...] = ()
        if any(one in own for one in sources):  # it has seen parts of these
            sources = tuple(one for one in sources if one in own)
            learned = node.settings["learned"], node.settings.get("stretch", float("inf"))
        file = str(self._place("traces") / f"{node.id}.npz")

        def take(found: Any) -> None:
            node.compared, node.on = found, sources
            self.session.save()

        page, given = self._page("compare", node), (self._effects, self.session.reading)
        job = jobs.Compare(file, page, node.file, sources, *given, *learned)
        self._begin("comparing it with unseen motion", job, take)

    def _diagnose(self, asked: Asked) -> None:
        node = self.session.node()
        sources = self.session.files(Role.SEARCH) or self.session.files(Role.LEARN)
        confirm = self.session.files(Role.CONFIRM)
        if not sources:
            raise UserError("there is no recording to search: put one under Search")

        def take(found: Any) -> None:
            node.diagnosed, node.what_if = found, None
            self.session.save()

        page, given = self._page("diagnose", node), (self._effects, self.session.reading)
        job = jobs.Search(page, node.file, sources, confirm, *given)
        self._begin("looking for what is missing", job, take)

    def _what_if(self, asked: Asked) -> None:
        node = self.session.node()
        found = [one for one in (node.diagnosed or {}).get("findings", []) if not one["once"]]
        if not found:
            raise UserError("there is nothing to try: look for what is missing first")

        def take(tried: Any) -> None:
            node.what_if = tried
            self.session.save()

        tried = tuple((one["effect"], one["joint"], one["shape"]) for one in found)
        tried, given = tried[: jobs.MOST_TRIED], (self._effects, self.session.reading)
        job = jobs.WhatIf(node.file, self.session.unseen(), tried, *given)
        self._begin("trying combinations", job, take)

    def _add(self, asked: Asked) -> None:
        node = self.session.node()
        effect, joint = str(asked["effect"]), str(asked["joint"])
        found = (node.diagnosed or {}).get("findings", [])
        known: Asked = next(
            (one for one in found if (one["effect"], one["joint"]) == (effect, joint)), {}
        )
        why = known.get("why") or {"why": "added by hand"}
        title, added = f"{effect.replace('_', ' ')} on {joint}", {"effect": effect, "joint": joint}
        self._add_to(node, added, why, title, known.get("shape", {}))

    def _add_to(
        self,
        node: Node,
        added: Asked,
        why: Asked,
        title: str,
        shape: Mapping[str, float] | None = None,
    ) -> None:
        """Add to a model what `Node.added` describes.

        Args:
            shape: as found, where `added` has none.
        """
        identity, file = self._new_model()

        def take(described: Any) -> None:
            made = Node(identity, file, node.id, f"+ {title}", described, settings=node.settings)
            made.added, made.why = added, why
            self.session.add_node(made)
            self._compare()

        form, shape = added.get("form", {}), added.get("shape") or shape or {}
        effect = CURVE if form else added["effect"]
        job = jobs.Add(file, node.file, effect, added["joint"], shape, why, self._effects, form)
        self._begin(f"adding {title}", job, take)

    def _move(self, asked: Asked) -> None:
        node, effect, joint = self.session.node(), str(asked["effect"]), str(asked["joint"])
        identity = self.session.name("t")
        file = str(self._place("motions") / f"{identity}.csv")
        title = f"{effect.replace('_', ' ')}" + (f" on {joint}" if joint else "")

        def take(made: Any) -> None:
            self.session.motions.append({"id": identity, "title": title, "file": file, **made})
            self.session.save()

        job = Move(file, node.file, effect, joint, self._effects)
        self._begin(f"making a motion that shows {title}", job, take)

    @property
    def _effects(self) -> str:
        return str(self.session.effects) if self.session.formulas else ""

    def _formula(self, asked: Asked) -> None:
        from lagrangian_ff.effects import EFFECTS
        from lagrangian_ff.effects.formula import formula_effect
        from lagrangian_ff.effects.user import check

        name, text = str(asked["name"]).strip(), str(asked["formula"])
        ranges = {str(k): (float(a), float(b)) for k, (a, b) in dict(asked["shapes"]).items()}
        if name in EFFECTS:
            raise UserError(f"{name} is an effect of the catalogue; choose another name")
        check(formula_effect(name, text, ranges))
        self.session.add_formula({"name": name, "formula": text, "shapes": ranges})

    def _cancel(self, asked: Asked) -> None:
        wanted = str(asked["work"])
        for one in list(self._running):
            if one.id == wanted:
                self._running.remove(one)
                one.worker.cancel()
                if isinstance(one.worker.job, Look):
                    one.failed("reading was cancelled; take it away and add it again")
                if isinstance(one.worker.job, Investigate):
                    one.failed("it was cancelled; its motions are kept under Data")
                self._said = f"{one.title}: cancelled"

    def _new_model(self) -> tuple[str, str]:
        """Return the name of the next model in the page, and its file."""
        identity = self.session.name("m")
        return identity, str(self._place("models") / f"{identity}.npz")

    def _page(self, kind: str, node: Node) -> str:
        return str(self._place("pages") / f"{kind}_{node.id}.html")

    def _place(self, name: str) -> Path:
        place = self.session.folder / name
        place.mkdir(exist_ok=True)
        return place
