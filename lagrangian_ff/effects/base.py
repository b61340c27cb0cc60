"""What an effect is: a named torque, linear in its parameters, that friction or hardware adds."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.kernels.states import States

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Parameter:
    """A coefficient the torque is linear in.

    Attributes:
        name: as in the formula.  unit: SI.  meaning: what it is, in a few words.
    """

    name: str
    unit: str
    meaning: str


@dataclass(frozen=True)
class Shape:
    """A number the torque is not linear in, searched within a range.

    Attributes:
        name: as in the formula.  unit: SI.  meaning: what it is, in a few words.
        low, high: the range searched, on a logarithmic scale.
        start: its value before any search.
    """

    name: str
    unit: str
    meaning: str
    low: float
    high: float
    start: float


class Effect(ABC):
    """One physical effect on the torque of one joint.

    A subclass is data, a formula and its docstring. Columns are what the parameters multiply:
    the torque of the effect is `columns @ parameters`, in N·m.
    """

    name: ClassVar[str]
    formula: ClassVar[str]
    source: ClassVar[str]
    meaning: ClassVar[str]
    parameters: ClassVar[tuple[Parameter, ...]]
    shapes: ClassVar[tuple[Shape, ...]] = ()

    @abstractmethod
    def columns(self, x: States, joint: int, shape: Mapping[str, float]) -> Floats:
        """(M, P) what each of the P parameters multiplies, for one joint's torque."""
