"""The lag of every joint's torque behind its position, as a diagnosis finds it."""

from dataclasses import dataclass, replace

from lagrangian_ff.recording.motion import Conditioning


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
        return delay_option(self.delay)

    def applied(self, conditioning: Conditioning) -> Conditioning:
        """Return settings of reading that undo it."""
        return replace(conditioning, effort_delay=self.delay)


def delay_option(delay: float) -> str:
    """Return the setting of reading that undoes a delay in s, as the command line has it."""
    return f"--effort-delay {delay:.4f}"


def late(whose: str, delay: float, deviation: float) -> str:
    """Return in words that the torque comes late, or the position where `delay` is negative.

    Args:
        whose: a joint, or "every joint".  delay, deviation: s.
    """
    which, other = ("torque", "position") if delay > 0 else ("position", "torque")
    return (
        f"the {which} of {whose} comes {1e3 * abs(delay):.1f} ± {1e3 * deviation:.1f} ms later "
        f"than its {other}"
    )
