"""What pages ask about torques that no effect of the catalogue fits: curves, and formulas."""

from collections.abc import Callable
from typing import Any, Protocol

from lagrangian_ff.errors import UserError
from lagrangian_ff.workbench import jobs
from lagrangian_ff.workbench.session import Node, Role, Session

Asked = dict[str, Any]


class Begin(Protocol):
    """Starts work in a process, or after the work under way."""

    def __call__(self, title: str, job: Any, take: Callable[[Any], None]) -> None: ...


class AddTo(Protocol):
    """Starts to add to a model what `Node.added` describes, for a reason."""

    def __call__(self, node: Node, added: Asked, why: Asked, title: str) -> None: ...


class Unlisted:
    """Curves and proposed formulas of a session.

    Args:
        session: on disk.
        begin: starts work.
        add: starts to add something to a model.

    Attributes:
        asks: what a page may ask, by name.
    """

    def __init__(self, session: Session, begin: Begin, add: AddTo) -> None:
        self._session, self._begin, self._add = session, begin, add
        self.asks: dict[str, Callable[[Asked], None]] = {
            "curve": self._curve,
            "propose": self._propose,
            "take": self._take,
        }

    def _curve(self, asked: Asked) -> None:
        """Take in as a curve what a diagnosis leaves unexplained."""
        node = self._session.node()
        effect, joint = str(asked["effect"]), str(asked["joint"])
        left = (node.diagnosed or {}).get("unexplained", [])
        found = next((o for o in left if (o["effect"], o["joint"]) == (effect, joint)), None)
        if found is None:
            raise UserError("this is not left unexplained any more: look again")
        added = {"effect": effect, "joint": joint, "form": found["form"]}
        self._add(node, added, found["why"], f"curve over {found['coordinate']} on {joint}")

    def _propose(self, asked: Asked) -> None:
        """Propose formulas for a joint."""
        session, joint = self._session, str(asked["joint"])
        node = session.node()
        sources = session.files(Role.SEARCH) or session.files(Role.LEARN)
        confirm = session.files(Role.CONFIRM)
        if not sources:
            raise UserError("there is no recording to search: put one under Search")

        def take(found: Any) -> None:
            node.proposed = {**node.proposed, joint: found}
            session.save()

        effects = str(session.effects) if session.formulas else ""
        job = jobs.Propose(node.file, joint, sources, confirm, effects, session.reading)
        self._begin(f"proposing formulas for {joint}", job, take)

    def _take(self, asked: Asked) -> None:
        """Add a proposed formula to the session, and to the model without a curve in its place."""
        session, node, joint = self._session, self._session.node(), str(asked["joint"])
        formulas = node.proposed.get(joint, {}).get("formulas", [])
        found = next((one for one in formulas if one["effect"] == str(asked["effect"])), None)
        if found is None:
            raise UserError("this formula is not proposed any more: propose again")
        below = self._below_curve(node, joint)
        name = self._free_name(found["file"])
        session.add_formula({**found["file"], "name": name})
        added = {"effect": name, "joint": joint, "shape": found["shape"]}
        self._add(below, added, found["why"], f"{name.replace('_', ' ')} on {joint}")

    def _below_curve(self, node: Node, joint: str) -> Node:
        """Return the model that a formula for a joint is added to: one without a curve there."""
        known = {one.id: one for one in self._session.nodes}
        chain = [node]
        while chain[-1].parent:
            chain.append(known[chain[-1].parent])
        curves = [k for k, n in enumerate(chain) if "form" in n.added and n.added["joint"] == joint]
        if not curves:
            return node
        if curves[-1] != len(curves) - 1:
            raise UserError(
                f"the model has a curve on {joint} below other steps: go back to the step before "
                "the curve, and propose there"
            )
        return chain[len(curves)]

    def _free_name(self, formula: Asked) -> str:
        """Return the name of a formula, another one if that belongs to another formula."""
        taken = {one["name"]: one for one in self._session.formulas}
        name, count = str(formula["name"]), 1
        while name in taken and {**taken[name], "name": ""} != {**formula, "name": ""}:
            count += 1
            name = f"{formula['name']}_{count}"
        return name
