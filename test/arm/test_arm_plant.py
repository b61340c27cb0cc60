"""The plant's physics: energy, inverse dynamics along its motion, friction, and the seam."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from arm_examples import bias, energy, mass_matrix, potential_energy
from numpy.typing import NDArray

from lagrangian_ff.arm import (
    HOME,
    PAPER_LOADS,
    ArmParameters,
    Gear,
    JointMoment,
    Plant,
    exciting_trajectory,
    limits,
    true_torque,
)
from lagrangian_ff.arm.body import Body
from lagrangian_ff.errors import ArmError

Floats = NDArray[np.float64]

FREE = ArmParameters(viscous=(0.0,) * 6, coulomb=(0.0,) * 6)
STILL = np.zeros(6)


@pytest.fixture
def plant() -> Iterator[Plant]:
    it = Plant()
    yield it
    it.close()


def followed(plant: Plant, seconds: float) -> Iterator[tuple[Floats, Floats, Floats]]:
    """Follow a fast motion from home; the torque of each step and the state it began in."""
    q, qd, qdd = exciting_trajectory(10).sample(np.arange(0.0, seconds, plant.dt))
    torque = plant.true_torque(q, qd, qdd)
    plant.reset(q[0])
    for k in range(len(q)):
        motor = torque[k] + 300.0 * (q[k] - plant.q) + 10.0 * (qd[k] - plant.qd)
        before = plant.q, plant.qd
        plant.step(motor)
        yield motor, *before


@pytest.mark.parametrize("loads", [None, PAPER_LOADS])
def test_what_the_motors_give_is_stored_or_lost_to_friction(loads: dict | None) -> None:
    plant = Plant(loads=loads)
    work = lost = moved = 0.0
    plant.reset(np.array(HOME))
    start = energy(plant)
    for motor, _, qd in followed(plant, 5.0):
        mean = 0.5 * (qd + plant.qd)
        work += plant.dt * float(motor @ mean)
        lost += plant.dt * float(plant.effect_torque @ mean)
        moved += plant.dt * float(np.abs(motor @ mean))
    gained = energy(plant) - start
    plant.close()
    assert lost > 0.1 * moved
    assert abs(gained) > 0.01 * moved
    # First order in the step of 1 ms: 0.005 % is found, of the energy that the motors moved.
    assert abs(work - lost - gained) < 3e-4 * moved


def test_motor_torque_agrees_with_pybullets_inverse_dynamics_along_the_motion(plant: Plant) -> None:
    worst, largest = 0.0, 0.0
    rotors = plant.parameters.reflected_inertia
    for k, (motor, q, qd) in enumerate(followed(plant, 3.0)):
        if k % 20:
            continue
        qdd = (plant.qd - qd) / plant.dt
        links = plant.body.inverse_dynamics(q[None], qd[None], qdd[None])[0]
        left = motor - plant.effect_torque - rotors * qdd - links
        worst = max(worst, float(np.abs(left).max()))
        largest = max(largest, float(np.abs(motor).max()))
    assert largest > 30.0
    assert worst < 1e-9 * largest


def test_a_step_moves_the_links_as_pybullets_own_step_does(plant: Plant) -> None:
    with Body() as body:
        for k, (_, q, qd) in enumerate(followed(plant, 1.0)):
            if k % 20:
                continue
            body.set_state(q, qd)
            body.advance(plant.load_torque)
            np.testing.assert_allclose((plant.q, plant.qd), body.state(), rtol=1e-12, atol=1e-13)


@pytest.mark.parametrize("gears", [[], [Gear(4, 2000.0, 5.0)]])
def test_a_joint_rests_at_its_stop_however_it_is_pushed(gears: list[Gear]) -> None:
    plant = Plant(gears=gears)
    home, stop = np.array(HOME), limits().upper[4]
    plant.reset(home)
    torque = plant.true_torque(home, STILL, STILL)
    torque[4] += 20.0
    for _ in range(2000):
        plant.step(torque + 200.0 * (home - plant.q) * (np.arange(6) != 4) - 20.0 * plant.qd)
    assert plant.q[4] == pytest.approx(stop, abs=2e-3)
    assert abs(plant.qd[4]) < 1e-6
    plant.close()


def test_without_friction_and_motors_the_arm_swings_and_keeps_its_energy() -> None:
    plant = Plant(FREE)
    plant.reset(np.array([0.0, 0.2, -0.8, 0.0, 0.4, 0.0]))
    before, height = energy(plant), potential_energy(plant.body)
    for _ in range(350):
        plant.step(STILL)
    assert np.all((limits().lower < plant.q) & (plant.q < limits().upper))
    fell = height - potential_energy(plant.body)
    assert fell > 5.0
    assert abs(energy(plant) - before) < 0.005 * fell
    plant.close()


def test_halving_the_step_halves_the_error_of_the_energy() -> None:
    errors = []
    for rate in (1000, 2000):
        plant = Plant(replace(FREE, physics_rate=rate))
        plant.reset(np.array([0.0, 0.2, -0.8, 0.0, 0.4, 0.0]))
        before = energy(plant)
        for _ in range(rate // 4):
            plant.step(STILL)
        errors.append(abs(energy(plant) - before))
        plant.close()
    assert errors[0] / errors[1] == pytest.approx(2.0, rel=0.1)


def test_rotors_slow_the_wrist_down() -> None:
    """Joint 6 alone is almost all rotor: qdd = tau / (g²J + link)."""
    plant = Plant(FREE)
    plant.reset(STILL)
    link = mass_matrix(plant.body, STILL)[5, 5]
    rotor = FREE.gear_ratio[5] ** 2 * FREE.rotor_inertia[5]
    assert rotor > link
    torque = bias(plant.body, STILL, STILL)
    torque[5] += 0.1
    plant.step(torque)
    assert plant.qdd[5] == pytest.approx(0.1 / (rotor + link), rel=0.05)
    plant.close()


def test_gravity_compensation_holds_the_arm_still(plant: Plant) -> None:
    home = np.array(HOME)
    plant.reset(home)
    torque = plant.true_torque(home, STILL, STILL)
    for _ in range(500):
        plant.step(torque)
    np.testing.assert_allclose(plant.q, home, atol=1e-9)


def test_stiff_friction_creeps_steadily_instead_of_chattering(plant: Plant) -> None:
    plant.reset(STILL)
    torque = plant.true_torque(STILL, STILL, STILL)
    half = 0.5 * np.array(plant.parameters.coulomb)
    velocities = []
    for _ in range(400):
        plant.step(torque + half)
        velocities.append(plant.qd)
    settled = np.array(velocities[200:])
    expected = np.arctanh(0.5) * np.array(plant.parameters.coulomb_velocity)
    # Viscous friction and the slow fall of the arm take a little of it.
    np.testing.assert_allclose(settled[-1], expected, rtol=0.25)
    assert np.abs(np.diff(settled, axis=0)).max() < 1e-5


def test_true_torque_is_links_rotors_and_friction(plant: Plant) -> None:
    p = plant.parameters
    q, qd, qdd = np.random.default_rng(0).normal(size=(3, 7, 6))
    expected = plant.body.inverse_dynamics(q, qd, qdd)
    expected += np.square(p.gear_ratio) * p.rotor_inertia * qdd
    np.testing.assert_allclose(plant.true_torque(q, qd, qdd, friction=False), expected)
    expected += p.viscous * qd + p.coulomb * np.tanh(qd / p.coulomb_velocity)
    np.testing.assert_allclose(plant.true_torque(q, qd, qdd), expected)
    np.testing.assert_allclose(plant.true_torque(q[2], qd[2], qdd[2]), expected[2])
    np.testing.assert_allclose(true_torque(q, qd, qdd), expected)


def test_true_torque_refuses_what_it_cannot_use(plant: Plant) -> None:
    q = np.zeros((4, 6))
    with pytest.raises(ArmError, match="one shape"):
        plant.true_torque(q, q, q[:3])
    with pytest.raises(ArmError, match="one shape"):
        plant.true_torque(q[:, :5], q[:, :5], q[:, :5])
    bad = q.copy()
    bad[2, 1] = np.nan
    with pytest.raises(ArmError, match="qd of joint_2 at sample 2 is not finite"):
        plant.true_torque(q, bad, q)


class Bristles:
    """Springs that slip: an effect with a state of its own, as a plug-in would bring it."""

    def __init__(self) -> None:
        self.stiffness, self.reach = 1000.0, 2e-3
        self.calls = 0
        self.reset(STILL)

    def reset(self, q: Floats) -> None:
        self.bent, self.last = np.zeros(6), np.array(q)

    def torque(self, moment: JointMoment) -> tuple[Floats, Floats]:
        bent = self.bent + moment.dt * moment.qd
        return self.stiffness * np.clip(bent, -self.reach, self.reach), np.full(6, 1.0)

    def advance(self, moment: JointMoment) -> None:
        self.calls += 1
        self.bent = np.clip(self.bent + moment.q - self.last, -self.reach, self.reach)
        self.last = moment.q


def test_an_effect_with_a_state_of_its_own_joins_the_plant() -> None:
    bristles = Bristles()
    plant = Plant(effects=[bristles])
    plant.reset(STILL)
    hold = bias(plant.body, STILL, STILL)
    push = np.array([1.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    for _ in range(1500):
        plant.step(hold + push)
    # Below the slip of 2 N·m the bristle carries the whole push: 1 N·m bends it by 1 mrad.
    assert plant.q[0] == pytest.approx(1e-3, rel=0.02)
    assert plant.effect_torque[0] == pytest.approx(1.0, rel=0.02)
    assert bristles.calls == 1500
    for _ in range(1500):
        plant.step(hold + 6.0 * push)
    assert plant.q[0] > 0.05
    assert plant.effect_torque[0] > 2.0
    plant.close()


def test_the_torque_balance_closes_with_effects_too() -> None:
    plant = Plant(effects=[Bristles()])
    rotors = plant.parameters.reflected_inertia
    for motor, _, _ in followed(plant, 0.5):
        left = motor - plant.effect_torque - rotors * plant.qdd - plant.load_torque
        assert np.abs(left).max() < 1e-9
    plant.close()
