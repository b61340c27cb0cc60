"""How a model is identified."""

from dataclasses import dataclass

from lagrangian_ff.errors import ModelError

SCALES = ("auto", "joint", "common")


@dataclass(frozen=True)
class Settings:
    """How a model is identified; the defaults are those of section IV-B but for `train`.

    The paper trains on the first third. A recording of half a minute rarely visits in its first
    third what the rest needs, so two thirds are the default here.

    Attributes:
        model: kernel and effects, e.g. `auto+fri`.
        train: the share of each recording, from its beginning, that is learned from; 1 uses all,
            and the error is then that of blocks left out in turn.
        samples: how many training samples hyperparameters are chosen on and an exact model is
            made from, evenly spread.
        block_seconds: length of a block of cross-validation, s.
        folds: in how many folds the blocks are left out.
        selection: how hyperparameters are chosen, `validation` or `evidence`.
        scale: how torques are normalised. `common` divides all by one number, so that the joints
            share one Lagrangian, with noise in proportion to each torque's spread; `joint`
            divides each torque by its own spread, right where the joints' units do not agree;
            `auto` tries both and keeps the better one.
        evaluations: how many settings of hyperparameters are tried; a climb of the evidence takes
            steps in proportion.
        positive: whether the mass matrix is kept positive definite along the training motion; the
            joints then have one unit of torque, and one Lagrangian.
        landmarks: how many training samples the kernel is built on where all of them are learned
            from; 0 makes the model exactly, from `samples` of them. None is 0 for up to two
            minutes of training motion, and 300 for more, or where `samples` are too many.
    """

    model: str = "auto+fri"
    train: float = 2.0 / 3.0
    samples: int = 500
    block_seconds: float = 3.0
    folds: int = 5
    selection: str = "validation"
    scale: str = "auto"
    evaluations: int = 90
    positive: bool = False
    landmarks: int | None = None

    def check(self) -> None:
        """Refuse settings that cannot work.

        Raises:
            ModelError: names the setting, what it was and what it may be.
        """
        if not 0.0 < self.train <= 1.0:
            raise ModelError(f"train is {self.train}, expected a share above 0 and at most 1")
        if self.samples < 10:
            raise ModelError(f"samples is {self.samples}, expected at least 10")
        if self.landmarks is not None and self.landmarks < 0:
            raise ModelError(f"landmarks is {self.landmarks}, expected 0 (exact) or more")
        if self.block_seconds <= 0.0:
            raise ModelError(f"block_seconds is {self.block_seconds}, expected above 0 s")
        if self.folds < 2:
            raise ModelError(f"folds is {self.folds}, expected at least 2")
        if self.scale not in SCALES:
            raise ModelError(f"scale is '{self.scale}', expected {', '.join(SCALES)}")
        if self.positive and self.scale == "joint":
            raise ModelError(
                "scale is 'joint', expected common or auto with positive: joints whose torques are "
                "in units of their own share no mass matrix"
            )
