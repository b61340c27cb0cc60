"""The investigations of a session: begun, permitted and stopped by pages, and kept.

No motion is permitted without a token: it is given with the question, for that question, and holds
once.
"""

import hmac
import secrets
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from lagrangian_ff.errors import UserError
from lagrangian_ff.files import whole
from lagrangian_ff.workbench.investigating import (
    PERMIT,
    REFUSE,
    STOP,
    Arm,
    Investigate,
    Wanted,
    check,
)
from lagrangian_ff.workbench.recordings import Asked, Begin
from lagrangian_ff.workbench.session import Card, Node, Role, Session
from lagrangian_ff.workbench.settings import Reading
from lagrangian_ff.worker import Worker

HOLDS = 120.0  # s in which a permission may be given
LIMITS = "joint_limits.yaml"
LOST = "the workbench ended before it did; its motions are kept under Data"


class Investigations:
    """What pages ask of investigations.

    Args:
        session: on disk.
        begin: starts work.
        look: reads a recording that has become a card.
        compare: compares a model with motion that it has not seen.
        arm: that may be moved; None for none.

    Attributes:
        asks: what a page may ask, by name.
    """

    def __init__(
        self,
        session: Session,
        begin: Begin,
        look: Callable[[Card], None],
        compare: Callable[[str], None],
        arm: Arm | None = None,
    ) -> None:
        self._session, self._begin, self._look, self._compare = session, begin, look, compare
        self._arm = arm
        self._worker: Worker[Any] | None = None
        self._now: Asked | None = None
        self._question: Asked | None = None
        self._told: Any = None
        self._halted = False
        self._tokens: dict[str, float] = {}
        self.asks: dict[str, Callable[[Asked], Asked | None]] = {
            "investigate": self._investigate,
            "limits": self._limits,
            "question": lambda asked: self._shown(),
            "permit": self._permit,
            "refuse": self._refuse,
            "halt": self._halt,
        }
        for one in session.investigations:
            if not one["ended"]:
                self._adopt(one)

    @property
    def moving(self) -> bool:
        """Return whether an investigation of a robot is under way."""
        return self._now is not None and self._arm is not None and self._arm.real

    def state(self) -> Asked:
        """Return what pages show of the arm that may be investigated, and of what it asks."""
        urdf, limits = self._session.urdf, self._session.folder / LIMITS
        kind = "" if self._arm is None else "robot" if self._arm.real else "simulated"
        return {
            "kind": kind,
            "urdf": Path(urdf).name if urdf else "",
            "limits": limits.exists(),
            "session": str(self._session.folder),
            "running": self._now["id"] if self._now else "",
            "halted": self._halted,
            "asks": f"{self._now['id']}.{self._question['number']}"
            if self._now and self._question
            else "",
        }

    def tick(self) -> bool:
        """Take what the process has said; return whether that was anything."""
        worker, now = self._worker, self._now
        if worker is None or now is None or worker.said is self._told:
            return False
        self._told = said = worker.said
        now["steps"] = said["steps"]
        for bag in said["bags"][len(now["bags"]) :]:
            self._look(self._card(bag, now))
        if said["asks"] != self._question:
            self._question = said["asks"]
            self._tokens.clear()
        self._session.save()
        return True

    def _adopt(self, lost: Asked) -> None:
        """Keep the recordings of one that was under way when the workbench was killed."""
        lost |= {"ended": "lost", "words": LOST}
        place = self._session.folder / "recordings" / str(lost["id"])
        for bag in sorted(map(str, place.glob("motion_*"))):
            if bag not in lost["bags"]:
                self._card(bag, lost)
        self._session.save()

    def _card(self, bag: str, now: Asked) -> Card:
        """Return the card of a recording, from which the next model is learned."""
        now["bags"].append(bag)
        card = self._session.add_card(f"{now['title']}, motion {len(now['bags'])}", Path(bag))
        card.role, card.scale = Role.LEARN, dict(now["scale"])
        self._session.save()
        return card

    def _investigate(self, asked: Asked) -> None:
        if self._arm is None:
            raise UserError("there is no arm to move: start the workbench with --live")
        if self._now is not None:
            raise UserError("an investigation is under way: wait for its end, or stop it")
        wanted = self._wanted(asked)
        check(wanted)
        session = self._session
        identity, number = session.name("i"), len(session.investigations) + 1
        folder = session.folder / "investigations" / identity
        pages = session.folder / "pages"
        pages.mkdir(exist_ok=True)
        learned = [one.scale for one in session.cards if one.role is Role.LEARN and one.scale]
        scale = dict(learned[0]) if self._arm.real and learned else {}
        job = Investigate(
            self._arm,
            wanted,
            str(folder),
            str(session.folder / "recordings" / identity),
            str(pages / f"investigation_{identity}.html"),
            str(session.effects) if session.formulas else "",
            session.effort,
            session.effort_delay,
            scale,
        )
        now: Asked = {
            "id": identity, "title": f"investigation {number}", "minutes": wanted.minutes,
            "speed": wanted.speed, "topic": wanted.topic, "steps": [], "bags": [], "scale": scale,
            "ended": "", "words": "", "story": None,
        }  # fmt: skip

        def began(worker: Worker[Any]) -> None:
            self._worker, self._told = worker, None

        session.investigations.append(now)
        session.save()
        self._now, self._halted = now, False
        self._begin("investigating", job, self._end, self._fail, began)

    def _wanted(self, asked: Asked) -> Wanted:
        assert self._arm is not None
        minutes, speed = float(asked["minutes"]), float(asked["speed"])
        if not self._arm.real:
            return Wanted(minutes, speed)
        file, urdf = self._session.folder / LIMITS, self._session.urdf
        source = str(asked["limits"])
        if source not in ("urdf", "file") or not (urdf if source == "urdf" else file.exists()):
            raise UserError(
                "say where the arm may go: choose a file of joint limits, or start the workbench "
                "with --urdf"
            )
        topic = str(asked["topic"])
        if not topic:
            raise UserError("nobody in the graph takes trajectories: there is no topic to move it")
        if source == "urdf":
            return Wanted(minutes, speed, topic, urdf)
        return Wanted(minutes, speed, topic, "", str(file))

    def _end(self, story: Any) -> None:
        """Take the story, and its models as steps."""
        self.tick()
        session, now = self._session, self._now
        assert now is not None
        models, session.effort_delay = story.pop("models"), story.pop("effort_delay")
        now |= {"ended": "yes", "words": story["words"], "story": story}
        self._over()
        scales = {file: dict(now["scale"]) for file in now["bags"]}
        read = Reading(session.effort, session.effort_delay, scales).record(now["bags"])
        settings = {"model": "", "asked": "", "urdf": "", **read, "learned": story.pop("learned"),
                    "stretch": story.pop("stretch")}  # fmt: skip
        parent, made = "", []
        for formula in story.pop("formulas"):
            session.add_formula(formula)
        for one in models:
            added, why = one["added"], one["why"]
            title = f"+ {title_of(added)}" if added else now["title"]
            node = Node(session.name("m"), one["file"], parent, title, one["described"])
            node.added, node.why, node.settings = added, why, settings
            session.nodes.append(node)
            parent = node.id
            made.append(node)
        if models:
            node.proposed = story["proposed"]
            now["node"] = node.id
            session.current, session.undone = node.id, []
        session.save()
        for node in made:
            self._compare(node.id)

    def _fail(self, error: str) -> None:
        """Keep what is known of one that did not come to an end."""
        self.tick()
        if self._now is not None:
            self._now |= {"ended": "failed", "words": error}
        self._over()
        self._session.save()

    def _over(self) -> None:
        self._worker = self._now = self._question = None
        self._tokens.clear()

    def _limits(self, asked: Asked) -> None:
        """Take a file of joint limits."""
        from lagrangian_ff.investigation.allowed import allowed, file_names

        name, file = str(asked["name"])[:200], self._session.folder / LIMITS
        try:
            with whole(file) as made:
                made.write_text(str(asked["text"]), encoding="utf-8")
                try:
                    allowed(file_names(made), file=made)
                except UserError as error:
                    raise UserError(str(error).replace(str(made), name)) from error
        except OSError as error:
            raise UserError(f"{file}: cannot be written: {error.strerror or error}") from error
        self._session.save()

    def _shown(self) -> Asked:
        """Return what is asked, with the token that permits it."""
        if self._question is None:
            raise UserError("nothing is asked now")
        token = secrets.token_urlsafe(24)
        self._tokens[token] = time.monotonic() + HOLDS
        return {**self._question, "token": token, "holds": HOLDS}

    def _permit(self, asked: Asked) -> None:
        given = str(asked["token"]).encode()
        known = [one for one in self._tokens if hmac.compare_digest(one.encode(), given)]
        if self._question is None or self._worker is None or not known:
            raise UserError("this was not asked, or is not asked any more: look at it again")
        if time.monotonic() > self._tokens.pop(known[0]):
            raise UserError("the permission came too late: look at it again")
        self._tokens.clear()
        self._worker.tell(f"{PERMIT} {self._question['number']}")

    def _refuse(self, asked: Asked) -> None:
        if self._question is not None and self._worker is not None:
            self._tokens.clear()
            self._worker.tell(f"{REFUSE} {self._question['number']}")

    def _halt(self, asked: Asked) -> None:
        """Stop the arm on its path, and end with what is known."""
        if self._worker is None:
            raise UserError("no investigation is under way")
        self._halted = True
        self._tokens.clear()
        self._worker.tell(STOP)


def title_of(added: Asked) -> str:
    """Return what a step added, in words."""
    return f"{added['effect'].replace('_', ' ')} on {added['joint']}"
