"""What the server answers about the curves of a comparison: windows, maps, and what is marked."""

import math

from lagrangian_ff.errors import UserError
from lagrangian_ff.workbench import traces
from lagrangian_ff.workbench.handler import Handler

WIDEST = 4000  # pixels
MAP_BINS = 36
AXES = ("q", "qd", "tau", "load", "time")


class Curves(Handler):
    """What is drawn of a comparison."""

    def curves(self, node: str) -> traces.Traces:
        """Return the curves of a model.

        Raises:
            UserError: it was not compared.
        """
        found = self.service.bench.session.node(node)
        file = self.service.bench.session.folder / "traces" / f"{found.id}.npz"
        if found.compared is None or not file.exists():
            raise UserError("this model was not compared yet")
        return traces.opened(str(file), file.stat().st_mtime)

    def axis(self, name: str, curves: traces.Traces) -> traces.Axis:
        """Return the quantity that a page names, such as qd:2.

        Raises:
            UserError: there is none.
        """
        quantity, _, joint = self.get_query_argument(name).partition(":")
        number = int(joint) if joint.isdigit() else 0
        if quantity not in AXES or number >= curves.series["tau"].shape[1]:
            raise UserError(f"there is no quantity {quantity}:{joint}")
        return traces.Axis(quantity, number)

    def number(self, name: str) -> float:
        """Return a number that a page gives.

        Raises:
            UserError: it is none.
        """
        try:
            value = float(self.get_query_argument(name))
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            raise UserError(f"{name} is no number")
        return value


class Trace(Curves):
    """The curves of a comparison between two times."""

    def get(self, node: str) -> None:
        curves = self.curves(node)
        start, end = (self.number(name) for name in ("start", "end"))
        width = min(WIDEST, max(1, int(self.number("width"))))
        asked = self.get_query_arguments("series")
        names = tuple(name for name in traces.SERIES if name in asked)
        self.set_header("Content-Type", "application/octet-stream")
        self.finish(curves.window(start, end, width, names))


class Map(Curves):
    """The error of a joint over two quantities."""

    def get(self, node: str) -> None:
        curves = self.curves(node)
        x, y, joint = (self.axis(name, curves) for name in ("x", "y", "joint"))
        self.say(curves.map(joint.joint, x, y, MAP_BINS))


class Chosen(Curves):
    """The stretches of time in which two quantities lie where a page has chosen."""

    def get(self, node: str) -> None:
        curves = self.curves(node)
        x, y = (self.axis(name, curves) for name in ("x", "y"))
        a, b, c, d = (self.number(name) for name in ("left", "right", "below", "above"))
        self.say({"spans": curves.chosen(x, y, (a, b), (c, d))})


class Lit(Curves):
    """Where the samples of stretches of time lie on a map."""

    def get(self, node: str) -> None:
        curves = self.curves(node)
        x, y = (self.axis(name, curves) for name in ("x", "y"))
        try:
            pairs = [one.split(":") for one in self.get_query_argument("spans").split(",")]
            spans = [(float(start), float(end)) for start, end in pairs]
        except ValueError:
            raise UserError("spans are no stretches of time") from None
        self.say({"bins": curves.lit(x, y, MAP_BINS, spans)})
