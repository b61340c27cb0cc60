"""The lag of every joint's torque behind its position, as a diagnosis finds it."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Lag:
    """A lag of every joint's torque behind its position: one delay, that of the driver.

    Attributes:
        delay: s; negative if the positions come late.
        deviation: s, its standard deviation.
        log_bayes_factor: nats.
        gained: nats on unseen motion.
    """

    delay: float
    deviation: float
    log_bayes_factor: float
    gained: float = 0.0

    @property
    def option(self) -> str:
        """Return the setting of reading that undoes it, as the command line has it."""
        return f"--effort-delay {self.delay:.4f}"

    def words(self) -> str:
        """Return it in a sentence."""
        which, other = ("torque", "position") if self.delay > 0 else ("position", "torque")
        return (
            f"The {which} of every joint comes {1e3 * abs(self.delay):.1f} ± "
            f"{1e3 * self.deviation:.1f} ms later than its {other}"
        )
