"""Intervals of a coordinate in the words a person would use.

Every function takes the ends of the interval and the lowest and highest value met in the motion:
an end that lies at the edge of the motion need not be said.
"""

NEAR = 0.02
"""Of the width of all values: an end so close to the edge of the motion is the edge."""


def number(value: float) -> str:
    """Two significant digits, or whole numbers from 100 on; a minus as people print it."""
    text = f"{value:.0f}" if abs(value) >= 100.0 else f"{value:#.2g}".rstrip(".")
    if "e" in text:
        text = f"{value:.2g}"
    return text.replace("-", "−") if float(value) != 0.0 else "0"


def _interval(
    low: float, high: float, lowest: float, highest: float, unit: str, names: tuple[str, str, str]
) -> str:
    """`names`: what is said of below, above and between, before the numbers."""
    slack = NEAR * (highest - lowest)
    low, high = (0.0 if abs(end) < 0.2 * slack else end for end in (low, high))
    below, above, between = names
    if low <= lowest + slack and high >= highest - slack:
        return ""
    if low <= lowest + slack:
        return f"{below} {number(high)} {unit}"
    if high >= highest - slack:
        return f"{above} {number(low)} {unit}"
    return f"{between} {number(low)} and {number(high)} {unit}"


def velocity(low: float, high: float, lowest: float, highest: float) -> str:
    """A signed velocity; one that is symmetric about zero is a speed."""
    if low < 0.0 < high and abs(low + high) < 1e-9 * (high - low):
        return f"below {number(high)} rad/s"
    return _interval(
        low, high, lowest, highest, "rad/s",
        ("at velocities below", "at velocities above", "at velocities between"),
    )  # fmt: skip


def speed(low: float, high: float, lowest: float, highest: float) -> str:
    """A speed, whatever its direction."""
    return _interval(low, high, 0.0, highest, "rad/s", ("below", "above", "between"))


def position(low: float, high: float, lowest: float, highest: float) -> str:
    """An angle."""
    return _interval(
        low, high, lowest, highest, "rad",
        ("at positions below", "at positions above", "at positions between"),
    )  # fmt: skip


def acceleration(low: float, high: float, lowest: float, highest: float) -> str:
    """A signed acceleration."""
    return _interval(
        low, high, lowest, highest, "rad/s²",
        ("at accelerations below", "at accelerations above", "at accelerations between"),
    )  # fmt: skip


def load(low: float, high: float, lowest: float, highest: float) -> str:
    """A signed load."""
    return _interval(
        low, high, lowest, highest, "N·m",
        ("under a load below", "under a load above", "under a load between"),
    )  # fmt: skip


def load_size(low: float, high: float, lowest: float, highest: float) -> str:
    """The size of a load."""
    return _interval(
        low, high, 0.0, highest, "N·m",
        ("under a load smaller than", "under a load greater than", "under a load of between"),
    )  # fmt: skip


def since_reversal(low: float, high: float, lowest: float, highest: float) -> str:
    """A time after a reversal; long ones are steady motion."""
    return _interval(
        low, high, 0.0, highest, "s",
        ("after a reversal, within", "after a reversal, later than", "after a reversal, between"),
    )  # fmt: skip


def before_reversal(low: float, high: float, lowest: float, highest: float) -> str:
    """A time before a reversal."""
    return _interval(
        low, high, 0.0, highest, "s",
        ("before a reversal, within", "before a reversal, by more than",
         "before a reversal, between"),
    )  # fmt: skip


def time(low: float, high: float, lowest: float, highest: float) -> str:
    """A part of the recording."""
    said = _interval(low, high, lowest, highest, "s", ("in the first", "after", "from"))
    return said.replace(" and ", " to ")


def direction(low: float, high: float, lowest: float, highest: float) -> str:
    """One of the two ways."""
    return "moving forwards" if low > 0.0 else "moving backwards"


def outside_range(low: float, high: float, lowest: float, highest: float) -> str:
    """Whether the model knows such motion."""
    if low > 0.0:
        return "outside the range the model was identified on"
    return "inside the range the model was identified on"


def percent(share: float) -> str:
    """A share in whole percent, finer below one."""
    return f"{100.0 * share:.0f} %" if share >= 0.00995 else f"{100.0 * share:.1f} %"
