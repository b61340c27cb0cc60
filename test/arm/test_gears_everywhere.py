"""What all gears have at once is in each joint what the hidden effect of one joint is."""

from contextlib import closing

import numpy as np
import pytest

from lagrangian_ff.arm import ArmParameters, JointMoment, Plant, true_torque
from lagrangian_ff.arm.hidden import gears
from lagrangian_ff.arm.hidden.base import rub
from lagrangian_ff.arm.hidden.solid import Bristles

SLIP, DISTANCE = np.linspace(0.5, 3.0, 6), np.linspace(1e-3, 5e-3, 6)


def test_bristles_in_all_joints_are_six_times_those_of_one() -> None:
    (every,) = gears.presliding(SLIP, DISTANCE).effects
    single = [Bristles(j, SLIP[j], DISTANCE[j]) for j in range(6)]
    for effect in (every, *single):
        effect.reset(np.zeros(6))
    for velocity in np.random.default_rng(0).normal(scale=0.3, size=(50, 6)):
        moment = JointMoment(0.0, 1e-3, np.zeros(6), velocity, np.zeros(6), np.zeros(6))
        expected = np.sum([one.torque(moment) for one in single], axis=0)
        np.testing.assert_allclose(every.torque(moment), expected, rtol=1e-12)
        for effect in (every, *single):
            effect.advance(moment)


def test_loaded_teeth_rub_in_proportion_to_the_load() -> None:
    share, load = np.linspace(0.02, 0.1, 6), np.array([10.0, -20.0, 5.0, 0.0, -1.0, 0.3])
    (teeth,) = gears.loaded_teeth(share).effects
    for velocity in (np.full(6, 0.5), np.full(6, -0.01), np.zeros(6)):
        moment = JointMoment(0.0, 1e-3, np.zeros(6), velocity, np.zeros(6), load)
        torque, chord = teeth.torque(moment)
        expected = [rub(s * abs(f), v) for s, f, v in zip(share, load, velocity, strict=True)]
        made = np.stack([torque, chord], axis=1)
        np.testing.assert_allclose(made, expected, rtol=1e-9, atol=1e-6)


def test_soft_gears_spare_the_joints_that_are_to_be_stiff() -> None:
    made = gears.soft_gears(np.full(6, 1e4), ArmParameters(), stiff=[2]).gears
    assert [gear.joint for gear in made] == [0, 1, 3, 4, 5]
    assert all(gear.stiffness == 1e4 and gear.damping > 0.0 for gear in made)


def test_links_of_another_mass_weigh_and_resist_accordingly() -> None:
    state = np.random.default_rng(1).uniform(-0.5, 0.5, size=(3, 4, 6))
    heavy, usual = (
        true_torque(*state, friction=False, parameters=ArmParameters(link_masses=(m,) * 6))
        for m in (1.3, 1.0)
    )
    rotors = ArmParameters().reflected_inertia * state[2]
    np.testing.assert_allclose(heavy - rotors, 1.3 * (usual - rotors), rtol=1e-9)
    with closing(Plant(ArmParameters(link_masses=(1.0,) * 5 + (2.0,)))) as tool:
        q, qd, qdd = state
        more = tool.true_torque(q, qd, qdd, friction=False) - usual
    assert np.abs(more).max(axis=0)[1] == pytest.approx(np.abs(more).max())
