"""An effect: a named torque, linear in its parameters, that friction or hardware adds."""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import ClassVar

import numpy as np

from lagrangian_ff.arrays import Floats
from lagrangian_ff.effects.inputs import Inputs
from lagrangian_ff.effects.time_limit import in_time
from lagrangian_ff.errors import EffectError

Values = Mapping[str, float]
"""The shapes of an effect, by name."""

KINDS = ("measurement", "friction", "transmission", "mechanics", "event")
"""The causes of effects, in the order to look for them: a fault of measurement looks like friction,
and is to be mended first."""

MOTIONS = (
    "exciting",
    "speeds",
    "slow sweep",
    "reversals",
    "chirp",
    "one by one",
    "warm-up",
    "payloads",
)
"""The motions that show effects or tell them apart."""


@dataclass(frozen=True)
class Origin:
    """Where an effect that users brought comes from.

    Attributes:
        name: of the file or package, for messages.
        file: the Python file; None for a package.
    """

    name: str
    file: Path | None = None


BROUGHT: dict[str, Origin] = {}
"""The effects that users brought, by name; also those that were replaced."""

PARTS = ("gravity", "inertia", "coriolis", "friction")
"""The parts of a torque. An effect goes with `friction` if it dissipates energy, else with
`gravity` if it is there at rest (a spring, an offset, an error in proportion to the load), else
with `inertia` (a rotor, a gear that swings)."""


@dataclass(frozen=True)
class Parameter:
    """A coefficient the torque is linear in.

    Attributes:
        name: as in the formula.  unit: SI.  meaning: what it is, in a few words.
        positive: whether nature has it above zero, as dissipation, stiffness, mass and inertia.
    """

    name: str
    unit: str
    meaning: str
    positive: bool = False


@dataclass(frozen=True)
class Shape:
    """A number the torque is not linear in, searched within a range.

    Attributes:
        name: as in the formula.  unit: SI.  meaning: what it is, in a few words.
        low, high: the range searched, on a logarithmic scale unless `even`.
        start: its value before any search.
        steps: how many values, spread evenly over that scale, are tried first.
        whole: whether only whole numbers mean anything; all of the range are tried then.
        joint: whether it is a joint, counted from 0.
        of_model: whether it makes up for what one model believes, so that it does not carry over
            to another.
        bounds: whether nature keeps within the range, so that data which ask for more, and end
            there, show something else.
        even: whether it is a place, which may be negative and is not searched logarithmically.
    """

    name: str
    unit: str
    meaning: str
    low: float
    high: float
    start: float
    steps: int = 6
    whole: bool = False
    joint: bool = False
    of_model: bool = False
    bounds: bool = False
    even: bool = False

    @property
    def zero(self) -> float:
        """Return what is taken from a value before its logarithm.

        Logarithms of an even range are taken from one range below it, where they are nearly even.
        """
        return 2.0 * self.low - self.high if self.even else 0.0

    def logarithm(self, value: float) -> float:
        """Return a value on the scale that is searched."""
        return float(np.log(value - self.zero))

    def value(self, logarithm: float) -> float:
        """Return the value that has a logarithm."""
        return float(self.zero + np.exp(logarithm))

    def grid(self) -> list[float]:
        """Return the values tried first."""
        if self.whole:
            return [float(k) for k in range(int(self.low), int(self.high) + 1)]
        scale = np.geomspace(self.low - self.zero, self.high - self.zero, self.steps)
        return [float(v) for v in self.zero + scale]

    def words(self, value: float, joints: Sequence[str]) -> str:
        """Return a value for a person: a joint by its name, a whole number without a point."""
        if self.joint and round(value) < len(joints):
            return joints[round(value)]
        return str(round(value)) if self.whole else f"{value:.3g}"


class Effect(ABC):
    """One physical effect on the torque of one joint.

    A subclass is data, a formula and its docstring. The parameters multiply its columns: the torque
    is `columns @ parameters`, in N·m. A subclass must give `name`, `formula`, `parameters` and
    `columns`; all else has a default.

    Attributes:
        name: one word, as the command line takes it.
        formula: the torque it adds, with parameters and shapes by their names.
        source: where the formula is from.
        meaning: what it is, for a person.
        parameters: the coefficients that the torque is linear in.
        shapes: the numbers that it is not linear in.
        kind: one of `KINDS`.
        part: one of `PARTS`, with which it is switched off.
        coordinate: what to plot the residual against to see it.
        shows_as: what is seen there.
        look_alikes: by name of effect, how to tell the two apart. One of a pair states it, for
            both: `catalogue.look_alikes` gives it both ways.
        motion: the one of `MOTIONS` that shows it best.
        next_motion: that motion in words.
        side_by_side: whether joints may stand in for samples: its columns follow from its own
            joint's state alone, and shapes may be arrays (M, 1).
        remembers: whether it depends on the past; its columns then get the whole motion.
        uses: the ones of `load` and `torque` of the inputs that it needs.
        caution: what no motion separates this effect from; empty for none.
        absorbed: whether any kernel that is free in position has it already, see `Kernel.free`.
        observable: whether motion alone can show it beside free rigid bodies and friction.
        plain: whether it is friction that every joint has.
        constant: whether it is one torque at all times; the load then has it.
        sign_width: the shape that is the speed v0 of the smoothed sign tanh(qd / v0) on its joint,
            for all effects there; empty for none.
        arm_event: `lasting` or `passing` for something that takes hold of the whole arm, for good
            or for a while; empty for none.
        rings: whether it swings after a jerk, and hardly shows in a smooth motion.
    """

    name: ClassVar[str]
    formula: ClassVar[str]
    source: ClassVar[str] = "user"
    meaning: ClassVar[str] = ""
    parameters: ClassVar[tuple[Parameter, ...]]
    shapes: ClassVar[tuple[Shape, ...]] = ()
    kind: ClassVar[str] = "friction"
    part: ClassVar[str] = "friction"
    coordinate: ClassVar[str] = "velocity"
    shows_as: ClassVar[str] = ""
    look_alikes: ClassVar[Mapping[str, str]] = {}
    motion: ClassVar[str] = "exciting"
    next_motion: ClassVar[str] = "move every joint through its whole range at several speeds"
    side_by_side: ClassVar[bool] = False
    remembers: ClassVar[bool] = False
    uses: ClassVar[frozenset[str]] = frozenset()
    caution: ClassVar[str] = ""
    absorbed: ClassVar[bool] = False
    observable: ClassVar[bool] = True
    plain: ClassVar[bool] = False
    constant: ClassVar[bool] = False
    sign_width: ClassVar[str] = ""
    arm_event: ClassVar[str] = ""
    rings: ClassVar[bool] = False

    @abstractmethod
    def columns(self, x: Inputs, joint: int, shape: Values) -> Floats:
        """Return (M, P) what each of the P parameters multiplies, for one joint's torque."""

    def energies(self, x: Inputs, joint: int, shape: Values) -> tuple[Floats, Floats] | None:
        """Return kinetic and potential energy, of effects that keep energy and belong to the arm.

        The torque is then d/dt ∂T/∂qd − ∂T/∂q + ∂V/∂q, with T quadratic in velocity.

        Returns:
            (M, P) each, J per unit of each of the P parameters; None if the effect dissipates
            energy, depends on more than the state, or is no part of the arm's mechanics.
        """
        return None

    def reach(self, shape: Values) -> float:
        """Return rad after a reversal within which its torque still turns over; 0 if at once."""
        return 0.0

    def others(self, joint: int, shape: Values) -> Mapping[int, float]:
        """Return the other joints whose torque it adds to: by index, the factor of its columns."""
        return {}

    def cause(self, joint: int, shape: Values) -> int:
        """Return the joint whose hardware adds this to the torque of `joint`."""
        return joint

    def possible(self, parameters: Floats) -> bool:
        """Return whether the hardware that causes it could have these parameters (P,)."""
        return True

    def speed(self, x: Inputs, joint: int, shape: Values) -> Floats:
        """Return (M,) rad/s of the shaft that its torque acts on: torque times speed is power."""
        return x.qd[:, joint]

    def signs(self, x: Inputs, joint: int, shape: Values) -> Mapping[str, Floats]:
        """Return the sums of its parameters that nature has above zero.

        The only positive parameter is one; of several together it is the power that friction takes
        out of the motion, so that one of them may be too small to measure.

        Returns:
            By words with the unit, the weights (P,) of such a sum.
        """
        positive = np.array([one.positive for one in self.parameters])
        if positive.sum() == 1:
            one = self.parameters[int(np.argmax(positive))]
            return {f"{one.name} in {one.unit}": positive.astype(np.float64)}
        if positive.any() and self.part == "friction":
            power = self.columns(x, joint, shape) * self.speed(x, joint, shape)[:, None]
            return {"the power it takes in W": np.where(positive, np.mean(power, axis=0), 0.0)}
        return {}

    def transferable(self, shape: Values) -> dict[str, float]:
        """Return what another model may take over of a shape; it searches the rest itself."""
        own = {one.name for one in self.shapes if one.of_model}
        return {name: value for name, value in shape.items() if name not in own}

    def shape_words(self, shape: Values, joints: Sequence[str]) -> dict[str, str]:
        """Return the values of a shape for a person, by name; see `Shape.words`."""
        kinds = {one.name: one for one in self.shapes}
        return {
            name: kinds[name].words(value, joints) for name, value in shape.items() if name in kinds
        }

    def candidates(self, x: Inputs, joint: int) -> Sequence[Values]:
        """Return the shapes to try on one joint: every combination of the shapes' grids."""
        names = [shape.name for shape in self.shapes]
        grids = [shape.grid() for shape in self.shapes]
        return [dict(zip(names, values, strict=True)) for values in product(*grids)]


def checked_columns(effect: Effect, x: Inputs, joint: int, shape: Values) -> Floats:
    """Return the columns (M, P) of an effect, after a check: a user may have written it.

    Raises:
        EffectError: they have another shape, or a value that is not finite, or take too long;
            names the effect.
    """
    if effect.name in BROUGHT:
        what = f"effect '{effect.name}': columns()"
        found = in_time(what, lambda: effect.columns(x, joint, shape), BROUGHT[effect.name].file)
    else:
        found = effect.columns(x, joint, shape)
    found = np.asarray(found, dtype=np.float64)
    expected = (len(x), len(effect.parameters))
    if found.shape != expected:
        raise EffectError(
            f"effect '{effect.name}': columns() gave shape {found.shape}, expected {expected}: "
            "one row a sample and one column a parameter"
        )
    if not np.isfinite(found).all():
        row, column = np.argwhere(~np.isfinite(found))[0]
        raise EffectError(
            f"effect '{effect.name}': columns() gave {found[row, column]} for the parameter "
            f"{effect.parameters[column].name} at sample {row}; expected finite values"
        )
    return found


def checked_energies(
    effect: Effect, x: Inputs, joint: int, shape: Values
) -> tuple[Floats, Floats] | None:
    """Return the energies of an effect after a check; see `Effect.energies`.

    Raises:
        EffectError: they are not two arrays of the columns' shape; names the effect.
    """
    found = effect.energies(x, joint, shape)
    if found is None:
        return None
    shapes = [np.shape(part) for part in found]
    expected = (len(x), len(effect.parameters))
    if shapes != [expected, expected]:
        raise EffectError(
            f"effect '{effect.name}': energies() gave shapes {shapes}, expected kinetic and "
            f"potential energy, each {expected}: one row a sample and one column a parameter"
        )
    kinetic, potential = (np.asarray(part, dtype=np.float64) for part in found)
    return kinetic, potential
