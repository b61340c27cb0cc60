"""Settings: to a model's record and back."""

import json

import pytest

from lagrangian_ff.errors import ModelError
from lagrangian_ff.identification import Settings


@pytest.mark.parametrize(
    "settings",
    [Settings(), Settings("energy", landmarks=40, positive=True, prismatic=("rail", "lift"))],
)
def test_they_survive_the_file(settings: Settings) -> None:
    record = settings.record()
    read = json.loads(json.dumps(record))
    assert read == record
    assert Settings.from_record(read) == settings


def test_settings_that_a_record_lacks_have_their_defaults() -> None:
    assert Settings.from_record({"samples": 50}) == Settings(samples=50)


@pytest.mark.parametrize("wrong", ["rail", [1], 3])
def test_joints_that_slide_are_names(wrong: object) -> None:
    with pytest.raises(ModelError, match=r"prismatic is .*, expected a tuple of joints' names"):
        Settings.from_record({"prismatic": wrong})
