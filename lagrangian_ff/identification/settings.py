"""The settings of an identification."""

from dataclasses import asdict, dataclass, fields
from math import inf
from numbers import Integral

from lagrangian_ff.errors import ModelError
from lagrangian_ff.recording.motion import WITHOUT_FRICTION

USUAL, USUAL_WITHOUT_FRICTION = "auto+fri", "auto"
SCALES = ("auto", "joint", "common")
CRITERIA = ("validation", "evidence")
LOSSES = ("square", "huber")


@dataclass(frozen=True)
class Settings:
    """The settings of an identification; samples, blocks and folds default to section IV-B.

    The paper trains on the first third. A recording of half a minute rarely visits in its first
    third what the rest needs, so two thirds are the default here.

    Attributes:
        model: kernel and effects, e.g. `auto+fri`.
        train: the share of each recording, from its beginning, that is learned from; 1 uses all,
            and the error is then that of blocks left out in turn.
        samples: number of training samples, evenly spread, that hyperparameters are chosen on
            and an exact model is made from.
        block_seconds: length of a block of cross-validation, s.
        folds: number of folds that the blocks are left out in.
        selection: criterion for hyperparameters, `validation` or `evidence`.
        scale: normalisation of torques. `common` divides all by one number, so that the joints
            share one Lagrangian, with noise in proportion to each torque's spread; `joint`
            divides each torque by its own spread, right where the joints' units do not agree;
            `auto` tries both, and gains of the drives that the evidence finds, and keeps what
            the data speak for.
        evaluations: points tried in the search for hyperparameters; maximising the evidence takes
            steps in proportion.
        positive: whether the mass matrix is kept positive definite along the training motion; the
            joints then have one unit of torque, and one Lagrangian.
        landmarks: number of inducing points, the training samples that the kernel is built on when
            all are learned from; 0 solves exactly, on `samples` of them. None is 0 for up to two
            minutes of training motion, and 300 for more, or if `samples` are too many, or where
            it is cheap, see `sizes`.
        loss: of residuals, `square`; or `huber`, which limits the pull of contacts and other gross
            errors in the recording.
        prismatic: names of the joints that slide, in m and N; the others turn.
    """

    model: str = USUAL
    train: float = 2.0 / 3.0
    samples: int = 500
    block_seconds: float = 3.0
    folds: int = 5
    selection: str = "validation"
    scale: str = "auto"
    evaluations: int = 90
    positive: bool = False
    landmarks: int | None = None
    loss: str = "square"
    prismatic: tuple[str, ...] = ()

    def record(self) -> dict[str, object]:
        """Return the settings by name, as JSON holds them."""
        # NumPy's whole numbers are taken, and are no numbers to JSON.
        whole = {name: int(getattr(self, name)) for name in ("samples", "folds", "evaluations")}
        return {**asdict(self), **whole, "prismatic": list(self.prismatic)}

    @classmethod
    def from_record(cls, record: object) -> "Settings":
        """Return the settings in a model's record; missing ones have their defaults.

        Raises:
            ModelError: the record has unknown or invalid settings.
        """
        known = [field.name for field in fields(cls)]
        if not isinstance(record, dict):
            raise ModelError(f"the model's settings are {record!r}, expected them by name")
        strange = sorted(str(name) for name in record if name not in known)
        if strange:
            raise ModelError(
                f"the model's settings hold {', '.join(strange)}, which this version does not "
                f"know; it knows {', '.join(known)}: update lagrangian_ff, or identify the model "
                "again"
            )
        held = dict(record)
        if isinstance(held.get("prismatic"), list):
            held["prismatic"] = tuple(held["prismatic"])
        settings = cls(**held)
        settings.check()
        return settings

    def check(self) -> None:
        """Refuse settings that cannot work.

        Raises:
            ModelError: names the setting, its value and the values that it may have.
        """
        if not (isinstance(self.train, (int, float)) and 0.0 < self.train <= 1.0):
            raise ModelError(f"train is {self.train}, expected a share above 0 and at most 1")
        if not (isinstance(self.block_seconds, (int, float)) and 0.0 < self.block_seconds < inf):
            raise ModelError(f"block_seconds is {self.block_seconds}, expected above 0 s")
        for name, least in (("samples", 10), ("folds", 2), ("evaluations", 1)):
            value = getattr(self, name)
            if not _whole(value, least):
                raise ModelError(f"{name} is {value}, expected a whole number of at least {least}")
        if self.landmarks is not None and not _whole(self.landmarks, 0):
            raise ModelError(f"landmarks is {self.landmarks}, expected 0 (exact) or more")
        for name, known in (("selection", CRITERIA), ("scale", SCALES), ("loss", LOSSES)):
            value = getattr(self, name)
            if value not in known:
                raise ModelError(f"{name} is '{value}', expected {', '.join(known)}")
        sliding = self.prismatic
        if not (isinstance(sliding, tuple) and all(isinstance(name, str) for name in sliding)):
            raise ModelError(f"prismatic is {sliding!r}, expected a tuple of joints' names")
        if self.positive and self.scale == "joint":
            raise ModelError(
                "scale is 'joint', expected common or auto with positive: joints whose torques are "
                "in units of their own share no mass matrix"
            )


def usual_model(effort: str) -> str:
    """Return the model to identify where none is named, for what the effort holds."""
    return USUAL_WITHOUT_FRICTION if effort == WITHOUT_FRICTION else USUAL


def _whole(value: object, least: int) -> bool:
    return isinstance(value, Integral) and int(value) >= least
