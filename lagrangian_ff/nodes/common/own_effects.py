"""Effects that the user brings, for models that have them."""

from pathlib import Path

from lagrangian_ff.effects import load_effects, load_installed


def load_own_effects(file: str) -> None:
    """Let the effects of installed packages and of a file join the catalogue.

    Args:
        file: Python that defines effects; empty for none.

    Raises:
        EffectError: the file cannot be used.
    """
    load_installed()
    if file:
        load_effects(Path(file).expanduser())
