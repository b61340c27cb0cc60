"""The service ~/load: recordings that exist, used as if they had been made here."""

from dataclasses import dataclass
from pathlib import Path

from lagrangian_ff.errors import UserError
from lagrangian_ff.nodes.common.status import Level, Status
from lagrangian_ff.nodes.recorder.jobs import base
from lagrangian_ff.nodes.recorder.session import Result, Session
from lagrangian_ff.progress import Progress


@dataclass(frozen=True, kw_only=True)
class Load(base.Job):
    """Read recordings once, to know that they can be used and which joints they have."""

    service, doing, title = "load", "loading", "recordings"

    @classmethod
    def refusal(cls, session: Session) -> str:
        """Return why nothing can be loaded now, or ""."""
        return session.refusal(cls.service)

    @classmethod
    def request(cls, given: base.Situation) -> "Load":
        """Return the request for those recordings of the parameter that are not there yet."""
        named = [base.absolute(name) for name in given.value("recordings") if name]
        if not named:
            raise UserError(
                "the parameter recordings names none: ros2 param set NODE recordings "
                "\"['path/of/bag']\", then call ~/load again"
            )
        fresh = [str(path) for path in dict.fromkeys(named) if path not in given.session.bags]
        if not fresh:
            raise UserError("the recordings that the parameter names are all loaded")
        return cls(**given.common, bags=tuple(fresh), output="")

    def summary(self) -> str:
        return f"started to load {base.names_of(self.bags)}"

    def work(self, progress: Progress) -> Result:
        """Return the recordings, each with its length in words."""
        lines, joints = [], dict[str, None]()
        for number, bag in enumerate(self.bags):
            progress(number / len(self.bags), f"reading {Path(bag).name}")
            found = self.open_recording(bag)
            seconds = float(found.time.max() - found.time.min())
            names = ", ".join(found.joints)
            lines.append(f"{bag}: {len(found)} samples in {seconds:.1f} s of {names}")
            joints |= dict.fromkeys(found.joints)
        said = f"loaded {base.names_of(self.bags)}"
        values = {f"recording {number}": line for number, line in enumerate(lines, 1)}
        status = Status(Level.OK, said, values)
        return Result((said, *lines), {self.title: status}, bags=self.bags, joints=tuple(joints))
