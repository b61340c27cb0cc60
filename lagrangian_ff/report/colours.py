"""Colours with a meaning, the same in every figure."""

INK, FAINT, GRID, FRAME = "#1f2933", "#7b8794", "#e4e7eb", "#cbd2d9"
MEASURED, PREDICTED, RESIDUAL = "#9aa5b1", "#1864ab", "#c2410c"
EFFECT = "#7048e8"
BEFORE, AFTER = "#9aa5b1", "#1864ab"
GOOD, BAD = "#2b8a3e", "#c2410c"
# Of runs, in the order in which they are drawn.
RUNS = ("#9aa5b1", "#e8910c", "#1864ab", "#2b8a3e", "#7048e8", "#c2255c")
# Of joints, from base to tool.
JOINTS = ("#e8910c", "#1864ab", "#2b8a3e", "#7048e8", "#c2255c", "#0b8599", "#7b8794")
# From nothing to much.
HEAT = ((0.0, "#f5f7fa"), (0.25, "#fde3cf"), (0.6, "#f08c4a"), (1.0, "#9a2f06"))


def of_joint(number: int) -> str:
    """Return the colour of a joint, counted from the base from 0."""
    return JOINTS[number % len(JOINTS)]


def faded(colour: str, share: float) -> str:
    """Return a colour with this share of opacity, as CSS and plotly.js take it."""
    red, green, blue = (int(colour[k : k + 2], 16) for k in (1, 3, 5))
    return f"rgba({red},{green},{blue},{share:g})"
