"""The diagnosis of two rods that hide an effect, and the search behind it."""

import pytest
import two_rods

from lagrangian_ff.diagnosis import Diagnosis, diagnose
from lagrangian_ff.diagnosis.search.forward import Search, search
from lagrangian_ff.diagnosis.whitening import fit
from lagrangian_ff.identification import Model, Settings, identify

FEW = Settings(train=1.0, samples=120, evaluations=20)


def model_of(hidden: two_rods.Hidden | None, seed: int = 1) -> Model:
    """Return a model of one recording."""
    return identify(two_rods.motion(seed, hidden=hidden), FEW).model


def diagnosed(hidden: two_rods.Hidden) -> Diagnosis:
    """Return the diagnosis of one recording, confirmed on a second."""
    first, second = (two_rods.motion(seed, hidden=hidden) for seed in (1, 2))
    return diagnose(model_of(hidden), first, second)


def search_of(found: Diagnosis) -> Search:
    """Return the search behind a diagnosis."""
    model, motion = found.model, found.motion
    return search(fit(motion, model.inputs_of(motion), model.basis))


@pytest.fixture(scope="module")
def stuck() -> Diagnosis:
    """Return the diagnosis of an arm whose elbow sticks, confirmed on a second recording."""
    return diagnosed(two_rods.stick)


@pytest.fixture(scope="module")
def stuck_search(stuck: Diagnosis) -> Search:
    """Return the search behind `stuck`."""
    return search_of(stuck)
