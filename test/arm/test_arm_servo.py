"""The servo against brute force and its own definition."""

import numpy as np
import pytest

from lagrangian_ff.arm import ArmParameters
from lagrangian_ff.arm.servo import CurrentLoop, PositionLoop, Sensors

PARAMETERS = ArmParameters()
RATIO = np.array(PARAMETERS.gear_ratio)
CONSTANT = np.array(PARAMETERS.torque_constant)


def test_the_discrete_current_loop_is_what_a_10_khz_loop_does() -> None:
    """A PI loop at 10 kHz on windings integrated in steps of 50 ns, joint by joint."""
    loop = CurrentLoop(PARAMETERS)
    random = np.random.default_rng(0)
    resistance, inductance = np.array(PARAMETERS.resistance), np.array(PARAMETERS.inductance)
    proportional = inductance * PARAMETERS.current_bandwidth
    integral = resistance * PARAMETERS.current_bandwidth
    current, integrator = np.zeros(6), np.zeros(6)
    period, fine = 1e-4, 2000
    for _ in range(3):
        torque, qd = random.normal(0, 10, 6), random.normal(0, 1, 6)
        wanted, emf = torque / (RATIO * CONSTANT), CONSTANT * RATIO * qd
        total = np.zeros(6)
        for _ in range(10):
            error = wanted - current
            voltage = proportional * error + integrator
            integrator = integrator + integral * period * error
            h = period / fine
            for _ in range(fine):
                middle = current + h / 2 * (voltage - resistance * current - emf) / inductance
                current = current + h * (voltage - resistance * middle - emf) / inductance
                total += h * middle
        mean = loop.step(torque, qd)
        np.testing.assert_allclose(loop.current, current, rtol=1e-6, atol=1e-7)
        np.testing.assert_allclose(mean, total / 1e-3 * RATIO * CONSTANT, rtol=1e-5, atol=1e-6)


def test_the_current_loop_settles_on_what_is_asked_against_back_emf() -> None:
    loop = CurrentLoop(PARAMETERS)
    torque, qd = np.full(6, 5.0), np.full(6, 1.5)
    first = loop.step(torque, np.zeros(6))
    assert np.all((first > 1.5) & (first < 4.5))
    for _ in range(200):
        mean = loop.step(torque, qd)
    np.testing.assert_allclose(mean, torque, rtol=1e-6)
    loop.reset()
    np.testing.assert_array_equal(loop.current, np.zeros(6))


def test_the_position_loop_is_pd_on_encoder_differences() -> None:
    loop = PositionLoop(PARAMETERS)
    stiffness, damping = np.array(PARAMETERS.stiffness), np.array(PARAMETERS.damping)
    here, ahead, qd = np.full(6, 0.1), np.full(6, 0.3), np.full(6, 0.2)
    np.testing.assert_allclose(loop.torque(ahead, qd, here), stiffness * 0.2 + damping * 0.2)
    moved = here + 0.25 / PARAMETERS.position_rate
    expected = stiffness * (ahead - moved) + damping * (qd - 0.25)
    np.testing.assert_allclose(loop.torque(ahead, qd, moved), expected)


def test_encoders_count_and_currents_are_noisy() -> None:
    sensors = Sensors(PARAMETERS, seed=3)
    random = np.random.default_rng(1)
    q, current = random.uniform(-2, 2, (2000, 6)), random.normal(size=6)
    samples = [sensors.sample(row, current) for row in q]
    position = np.array([s[0] for s in samples])
    step = 2 * np.pi / (2048 * RATIO)
    counts = position / step
    np.testing.assert_allclose(counts, np.round(counts), atol=1e-6)
    assert np.all(np.abs(position - q) <= 0.5 * step + 1e-12)
    velocity = np.array([s[1] for s in samples])
    np.testing.assert_allclose(velocity[1:], np.diff(position, axis=0) * 500, atol=1e-9)
    amperes = np.array([s[2] for s in samples]) / (RATIO * CONSTANT)
    np.testing.assert_allclose(amperes.mean(axis=0), current, atol=0.02)
    np.testing.assert_allclose(amperes.std(axis=0), PARAMETERS.current_noise, rtol=0.1)


def test_a_driver_without_velocity_reports_nan() -> None:
    sensors = Sensors(ArmParameters(velocity_measured=False), seed=0)
    sensors.sample(np.zeros(6), np.zeros(6))
    assert np.all(np.isnan(sensors.sample(np.ones(6), np.zeros(6))[1]))


@pytest.mark.parametrize("seed", [0, 5])
def test_noise_repeats_after_a_reset(seed: int) -> None:
    sensors = Sensors(PARAMETERS, seed)
    first = [sensors.sample(np.zeros(6), np.zeros(6))[2] for _ in range(5)]
    sensors.reset()
    again = [sensors.sample(np.zeros(6), np.zeros(6))[2] for _ in range(5)]
    np.testing.assert_array_equal(first, again)
