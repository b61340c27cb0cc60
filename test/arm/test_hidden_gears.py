"""Joints of two masses: their statics, their energy, their play, and the limit of stiff gears."""

import numpy as np
import pytest
from arm_examples import bias, energy, mass_matrix

from lagrangian_ff.arm import HOME, ArmParameters, Gear, Plant, exciting_trajectory, simulate

FREE = ArmParameters(viscous=(0.0,) * 6, coulomb=(0.0,) * 6)
STILL = np.zeros(6)
REST = np.array(HOME)


def test_at_rest_the_gear_is_twisted_by_the_load() -> None:
    plant = Plant(gears=[Gear(1, 2000.0, 40.0)])
    plant.reset(REST)
    hold = bias(plant.body, REST, STILL)
    for _ in range(3000):
        hold = bias(plant.body, plant.q, STILL)
        plant.step(hold - 20.0 * plant.rotor_velocity)
    twist = plant.encoder - plant.q
    load = bias(plant.body, plant.q, STILL)
    assert twist[1] == pytest.approx(load[1] / 2000.0, rel=0.02)
    np.testing.assert_array_equal(np.delete(twist, 1), 0.0)
    plant.close()


def test_rotor_against_link_rings_at_its_frequency() -> None:
    """With the arm's inertia at that joint M, ω² = k (1 / M + 1 / g²J); gravity adds little."""
    stiffness = 4000.0
    plant = Plant(FREE, gears=[Gear(0, stiffness, 0.0)])
    plant.reset(REST)
    mass = np.linalg.inv(np.linalg.inv(mass_matrix(plant.body, REST) + np.diag(
        [0.0, *FREE.reflected_inertia[1:]]))[:1, :1])[0, 0]  # fmt: skip
    expected = np.sqrt(stiffness * (1.0 / mass + 1.0 / FREE.reflected_inertia[0])) / (2.0 * np.pi)
    kick = bias(plant.body, REST, STILL)
    twist = []
    for k in range(1000):
        motor = bias(plant.body, plant.q, plant.qd)
        motor[0] += 20.0 if k < 5 else 0.0
        plant.step(motor)
        twist.append((plant.encoder - plant.q)[0])
    assert kick.shape == (6,)
    crossings = np.flatnonzero(np.diff(np.sign(twist[10:])) > 0)
    frequency = 1.0 / (np.diff(crossings).mean() * plant.dt)
    assert frequency == pytest.approx(expected, rel=0.05)
    plant.close()


def test_a_gear_never_gives_energy() -> None:
    gears = [Gear(1, 3000.0, 5.0, 0.004), Gear(4, 60.0, 0.1)]
    plant = Plant(FREE, gears=gears)
    plant.reset(np.array([0.0, 0.2, -0.8, 0.0, 0.4, 0.0]))
    held = [energy(plant, gears)]
    for _ in range(300):
        plant.step(STILL)
        held.append(energy(plant, gears))
    fell = np.ptp(held)
    assert np.diff(held).max() < 1e-3
    assert held[-1] <= held[0]
    assert fell > 0.0
    plant.close()


def test_a_stiff_gear_moves_like_none() -> None:
    motion = exciting_trajectory(6, 1, duration=4.0)
    rigid = simulate(motion)
    stiff = simulate(motion, gears=[Gear(1, 3e5, 300.0)])
    assert np.abs(stiff.position - rigid.position).max() < 1e-3
    assert np.abs(stiff.encoder - stiff.position)[:, 1].max() < 1e-3
    gap = np.sqrt(np.mean((stiff.motor_torque - rigid.motor_torque) ** 2, axis=0))[1]
    assert gap < 0.03 * np.sqrt(np.mean(rigid.motor_torque[:, 1] ** 2))


def test_play_lets_the_rotor_turn_before_the_link() -> None:
    play = 0.02
    plant = Plant(gears=[Gear(0, 1.2e4, 100.0, play)])
    plant.reset(STILL)
    hold = bias(plant.body, STILL, STILL)
    push = np.array([6.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    while plant.encoder[0] < 0.45 * play:
        plant.step(hold + push)
    # Only rounding and the other joints' fall have reached the link so far.
    assert abs(plant.q[0]) < 0.02 * play
    for _ in range(200):
        plant.step(hold + push)
    assert plant.q[0] > play
    twist = plant.encoder[0] - plant.q[0]
    assert 0.5 * play <= twist < 0.5 * play + push[0] / 1.2e4
    plant.close()


def test_friction_sits_on_the_rotor_and_the_encoder_too() -> None:
    motion = exciting_trajectory(6, 1, duration=4.0)
    run = simulate(motion, gears=[Gear(1, 1500.0, 5.0)])
    twist = (run.encoder - run.position)[:, 1]
    assert np.abs(twist).max() > 5e-3
    step = ArmParameters().encoder_step[1]
    np.testing.assert_allclose(run.recording.position, run.encoder, atol=0.51 * step * 2)
    rotor = np.gradient(run.encoder, 0.002, axis=0)
    friction = Plant()
    expected = friction.friction.at(rotor)[:, 1]
    friction.close()
    assert np.corrcoef(expected, run.effect_torque[:, 1])[0, 1] > 0.99
