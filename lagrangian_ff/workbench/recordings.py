"""What is done to recordings: read, looked at, and read again with a remedy."""

from collections.abc import Callable
from typing import Any, Protocol

from lagrangian_ff.recording.motion import Conditioning
from lagrangian_ff.workbench.aside import Aside, Later
from lagrangian_ff.workbench.looking import Look, Observe
from lagrangian_ff.workbench.session import Card, Role, Session
from lagrangian_ff.worker import Worker

Asked = dict[str, Any]


class Begin(Protocol):
    """Starts work in a process, or after the work under way."""

    def __call__(
        self,
        title: str,
        job: Any,
        take: Callable[[Any], None],
        failed: Callable[[str], None] | None = None,
        began: Callable[[Worker[Any]], None] = ...,
    ) -> None: ...


class Recordings:
    """The recordings of a session.

    Args:
        session: on disk.
        begin: starts work that somebody waits for.

    Attributes:
        aside: the work that nobody waits for.
        asks: what a page may ask, by name.
    """

    def __init__(self, session: Session, begin: Begin) -> None:
        self._session, self._begin = session, begin
        self.aside = Aside()
        self.asks: dict[str, Callable[[Asked], None]] = {
            "role": self._role,
            "remove": self._remove,
            "observe": lambda asked: self._observe(session.card(str(asked["card"]))),
            "skip": self._skip,
        }

    def begin(self) -> None:
        """Go on with the recordings of a session that was opened again."""
        for card in self._session.cards:
            if card.looked is None and not card.error:
                self.look(card)
            elif card.looked and card.observed is None and not card.unobserved:
                self._observe(card)

    def look(self, card: Card) -> None:
        """Read a recording, and then find out what it could show."""

        def take(found: Any) -> None:
            card.looked = found
            self._observe(card)

        def failed(error: str) -> None:
            card.error = error
            self._session.save()

        self._begin(f"reading {card.name}", Look(card.file, self._session.reading), take, failed)

    def _observe(self, card: Card) -> None:
        def take(found: Any) -> None:
            card.observed = found
            self._session.save()

        def failed(error: str) -> None:
            card.unobserved = error
            self._session.save()

        card.observed, card.unobserved = None, ""
        self._session.save()
        joints = (card.looked or {}).get("order")
        if joints is None:  # read by an older version
            return self.look(card)
        job = Observe(card.file, tuple(joints), self._session.reading)
        return self.aside.add(Later(card.id, job, take, failed))

    def _skip(self, asked: Asked) -> None:
        """Give up finding out what a recording could show."""
        card = self._session.card(str(asked["card"]))
        self.aside.drop(card.id)
        if card.observed is None:
            card.unobserved = "cancelled"
            self._session.save()

    def read(self, asked: Asked) -> set[str]:
        """Read recordings again: with what all effort holds or its delay, or the scale of some.

        Returns:
            Their files.
        """
        session = self._session
        cards = [session.card(str(one)) for one in asked.get("cards", ())]
        effort = str(asked.get("effort") or session.effort)
        given = asked.get("delay")
        delay = session.effort_delay if given is None else float(given)
        scale = {str(joint): float(factor) for joint, factor in dict(asked["scale"]).items()}
        # Made only to refuse settings that cannot be.
        Conditioning(effort=effort, effort_delay=delay, effort_scale=scale)
        if (effort, delay) != (session.effort, session.effort_delay):
            session.effort, session.effort_delay = effort, delay
            cards = list(session.cards)
        elif asked.get("effort") or given is not None:
            cards = []  # they are read so already
        else:
            for card in cards:
                card.scale = {**card.scale, **scale} if scale else {}
        for card in cards:
            self.aside.drop(card.id)
            card.looked = card.observed = None
            card.error = card.unobserved = ""
        session.save()
        for card in cards:
            self.look(card)
        return {card.file for card in cards}

    def _role(self, asked: Asked) -> None:
        card, role = self._session.card(str(asked["card"])), Role(asked["role"])
        if card.role is not role:
            card.role = role
            self._session.save()

    def _remove(self, asked: Asked) -> None:
        self.aside.drop(str(asked["card"]))
        self._session.remove_card(str(asked["card"]))
