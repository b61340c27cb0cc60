"""Changes of a known robot's bodies are named in kg, m and rad."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
import two_rods
from mechanism_examples import pendulum_urdf

from lagrangian_ff.diagnosis import since, thresholds
from lagrangian_ff.diagnosis.bodies import BodyChange, changed_bodies
from lagrangian_ff.diagnosis.competing import MASSES
from lagrangian_ff.diagnosis.thresholds import Effort, using
from lagrangian_ff.diagnosis.whitening import Whitened, fit, whiten
from lagrangian_ff.effects import EFFECTS
from lagrangian_ff.identification import Model, Settings, identify
from lagrangian_ff.kernels import KERNELS
from lagrangian_ff.kernels.rigid import robot_of
from lagrangian_ff.recording.motion import Conditioning, concatenate

pytest.importorskip("pinocchio", reason="Pinocchio, the extra urdf, is not installed")

Floats = two_rods.Floats

TILT, MORE = 0.1, 0.4  # rad, kg
BOUNDARY = 40.0  # s


@pytest.fixture(autouse=True, scope="module")
def _small() -> Iterator[None]:
    """Examine few torques, for changes of friction alone."""
    every = dict(EFFECTS)
    for name in set(every) - {"viscous", "coulomb", "offset"}:
        del EFFECTS[name]
    with using(effort=Effort(900, ((60, 6), (120, 2), (240, 1)))):
        yield
    EFFECTS.clear()
    EFFECTS.update(every)


@pytest.fixture(scope="module")
def model() -> Model:
    """Return a model of the rods whose URDF has one of them too heavy."""
    settings = Settings("none+fri", train=1.0, samples=100, evaluations=12)
    robot = robot_of(pendulum_urdf(2.4, 1.0), "rods.urdf")
    return identify(two_rods.motion(1, 20.0), settings, mechanism=robot).model


@pytest.fixture(scope="module")
def plain(model: Model) -> Whitened:
    """Return the whitened of the motion the model knows and of as much from `BOUNDARY` on."""
    new = two_rods.motion(2, 20.0)
    both = concatenate([model.data, replace(new, time=new.time + BOUNDARY)])
    return fit(both, model.inputs_of(both), model.basis)


def changed(model: Model, plain: Whitened, torque: Floats) -> BodyChange:
    """Return what is found if the second motion has (M, 2) N·m more."""
    tau = plain.motion.tau.copy()
    tau[plain.motion.time >= BOUNDARY] += torque
    motion = replace(plain.motion, tau=tau)
    parts = plain.index, plain.seconds, plain.inputs, plain.problem
    found = changed_bodies(model, whiten(motion, *parts, plain.x), BOUNDARY)
    assert found is not None
    return found


def second(plain: Whitened) -> tuple[Floats, Floats, Floats]:
    """q, qd and qdd, (M, 2) each, from the boundary on."""
    later = plain.motion.time >= BOUNDARY
    return plain.motion.q[later], plain.motion.qd[later], plain.motion.qdd[later]


def assert_holds(found: BodyChange, name: str, truth: float, unit: str, least: float) -> None:
    """The parameter is the truth within twice its interval, which is small."""
    one = found.parameters[name]
    assert one.unit == unit
    half = one.high - one.value
    assert half < 1.645 * least
    assert abs(one.value - truth) < 2.0 * half


def test_a_payload_is_found_in_kilograms_and_where(model: Model, plain: Whitened) -> None:
    q, qd, qdd = second(plain)
    load = two_rods.rods(q, qd, qdd, two_rods.LOAD) - two_rods.rods(q, qd, qdd)
    found = changed(model, plain, load)
    assert found.what == "payload"
    assert_holds(found, "m", two_rods.LOAD, "kg", 0.2)
    assert_holds(found, "x", 0.4, "m", 0.1)
    # A motion in a plane does not show where the load is across it.
    assert "y" not in found.parameters


def test_a_mass_is_no_surer_than_the_gain_of_the_drives(model: Model, plain: Whitened) -> None:
    """A gain that is 12 % wrong makes the mass as wrong; one that was measured leaves it sure."""
    q, qd, qdd = second(plain)
    load = two_rods.rods(q, qd, qdd, two_rods.LOAD) - two_rods.rods(q, qd, qdd)
    wrong = changed(model, plain, 1.12 * load).parameters["m"]
    assert wrong.low < two_rods.LOAD < wrong.high
    scaled = Conditioning(effort_scale=dict.fromkeys(two_rods.JOINTS, 1.0)).record()
    sure = replace(model, data=replace(model.data, conditioning=scaled))
    calibrated = changed(sure, plain, load).parameters["m"]
    assert calibrated.low < two_rods.LOAD < calibrated.high
    assert calibrated.high - calibrated.low < 0.5 * (wrong.high - wrong.low)


def test_a_tilted_base_is_found_in_radians(model: Model, plain: Whitened) -> None:
    """Turned about y, all angles to the horizon are less by that."""
    first = second(plain)[0][:, 0]
    both = second(plain)[0].sum(axis=1)
    forearm = 9.81 * 0.2 * (np.cos(both - TILT) - np.cos(both))
    arm = 9.81 * (np.cos(first - TILT) - np.cos(first))
    found = changed(model, plain, np.stack([arm + forearm, forearm], axis=1))
    assert found.what == "tilted base"
    assert_holds(found, "about y", TILT, "rad", 0.01)
    assert list(found.parameters) == ["about y"]


def test_a_link_of_another_mass_is_named(model: Model, plain: Whitened) -> None:
    q, _, qdd = second(plain)
    more = MORE * (0.25 / 3 * qdd[:, 0] + 9.81 * 0.25 * np.cos(q[:, 0]))
    found = changed(model, plain, np.stack([more, 0.0 * more], axis=1))
    assert found.what == "mass of the link of shoulder"
    assert_holds(found, "m", MORE, "kg", 0.05)


def test_no_body_is_blamed_where_none_changed(model: Model, plain: Whitened) -> None:
    worn = 0.5 * np.tanh(second(plain)[1][:, 1] / two_rods.WIDTH)
    assert (
        changed(model, plain, np.stack([0.0 * worn, worn], axis=1)).log_bayes_factor
        < thresholds.USED.change_floor
    )
    assert changed(model, plain, np.zeros((len(worn), 2))).log_bayes_factor < 0.0


def test_a_model_without_a_urdf_knows_no_bodies(model: Model, plain: Whitened) -> None:
    unknown = KERNELS["none"].start(model.centres)
    blind = replace(model, prior=replace(model.prior, kernel=unknown))
    assert changed_bodies(blind, plain, BOUNDARY) is None


def test_what_changed_since_names_the_payload(model: Model) -> None:
    found, *others = since.changed_since(model, two_rods.motion(2, 20.0, load_since=-1.0))
    assert found.what == "payload"
    assert set(found.joints) == {"shoulder", "elbow"}
    assert not [one for one in others if one.what in ("payload", MASSES)]
    mass = found.parameters["m"]
    assert mass.unit == "kg"
    assert mass.low < two_rods.LOAD < mass.high
