"""What is known of a mechanism before any torque is seen."""

from abc import ABC, abstractmethod

from lagrangian_ff.kernels.base import Kernel


class Mechanism(ABC):
    """Makes the kernels of a mechanism out of kernels that know nothing of it.

    A family of kernels is a class (see `Kernel.start`), and so is what is made of it: a model is
    chosen, fitted and judged with either in the same way.
    """

    @abstractmethod
    def of_joints(self, joints: tuple[str, ...], source: str) -> "Mechanism":
        """The mechanism with its coordinates in the order of a recording.

        Args:
            joints: N names.  source: where they are from, for the message.

        Raises:
            ModelError: the mechanism lacks one; names the joints of both.
        """

    @abstractmethod
    def around(self, family: type[Kernel]) -> type[Kernel]:
        """The kernels of this mechanism that learn by a family what is not known of it.

        Raises:
            ModelError: the family does not do for it.
        """

    @abstractmethod
    def record(self) -> dict[str, object]:
        """What is known, for a person; as JSON holds it."""

    @abstractmethod
    def stored(self) -> dict[str, object]:
        """What a model's file keeps of it; as JSON holds it, with `kind` telling the class."""
