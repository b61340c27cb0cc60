"""The servo of the paper's arm: PI current loop within a PD position loop, and the sensors."""

from collections.abc import Iterator, Sequence
from typing import Protocol

import numpy as np

from lagrangian_ff.arm.description import JOINTS
from lagrangian_ff.arm.parameters import ArmParameters
from lagrangian_ff.arrays import Floats
from lagrangian_ff.loops import loop

NOISES = 1000  # samples
NUMBERS = np.dtype(
    [
        ("map", "f8", (len(JOINTS), 3, 4)),
        *(
            (name, "f8", len(JOINTS))
            for name in ("per_ampere", "current", "integrator", "wanted", "qd", "mean")
        ),
    ]
)
"""The data of `arm_currents` in loops/arm.c."""


class CurrentLoop:
    """Windings under their PI controllers, over one step of the integration at a time.

    Within a period T of the PI loop the voltage V = K (r − i) + w is held, and the current obeys
    L di/dt = V − R i − E with E the back-EMF; then w grows by (K R / L) T (r − i). With z =
    (i, w, r, E, ∫i dt) this is one linear map F a period, and n periods are Fⁿ: exact, without
    stepping at 10 kHz. K = L b and K R / L cancel the winding's pole and leave the bandwidth b.
    The supply voltage is taken as sufficient: limits act on the current that is asked for.
    """

    def __init__(self, parameters: ArmParameters) -> None:
        periods = parameters.current_rate // parameters.physics_rate
        period = 1.0 / parameters.current_rate
        windings = zip(parameters.resistance, parameters.inductance, strict=True)
        one = [one_period(*winding, parameters.current_bandwidth, period) for winding in windings]
        table = np.linalg.matrix_power(np.array(one), periods)
        # Rows: current and integrator afterwards, mean current; columns: what they follow from.
        table = table[:, (0, 1, 4), :4]
        table[:, 2] *= parameters.physics_rate
        self._numbers = np.zeros((), NUMBERS)
        self._numbers["map"] = table
        # Torque in N·m/A is back-EMF in V·s/rad, both of the joint.
        self._numbers["per_ampere"] = parameters.torque_per_ampere
        self._wanted, self._qd = self._numbers["wanted"], self._numbers["qd"]
        self._current, self._mean = self._numbers["current"], self._numbers["mean"]
        self._step, self._address = loop("arm_currents"), self._numbers.ctypes.data

    def reset(self) -> None:
        """Set current and integrator to zero."""
        self._numbers["current"] = self._numbers["integrator"] = 0.0

    @property
    def current(self) -> Floats:
        """Return the present current, (6,) A."""
        return self._current.copy()

    def step(self, torque: Floats, qd: Floats) -> Floats:
        """Follow the torque asked for during one step of the integration.

        Args:
            torque: (6,) N·m asked for, at the joints.  qd: (6,) rad/s of the joints.

        Returns:
            (6,) N·m the motors gave on average, at the joints.
        """
        self._wanted[:], self._qd[:] = torque, qd
        self._step(self._address)
        return self._mean.copy()


def one_period(resistance: float, inductance: float, bandwidth: float, period: float) -> Floats:
    """Return (5, 5) F of CurrentLoop: z = (i, w, r, E, ∫i dt) over one period of the PI loop."""
    decay = np.exp(-resistance / inductance * period)
    rise = (1.0 - decay) / resistance
    gain = inductance * bandwidth
    # i(t) = i e^(−Rt/L) + (V − E)(1 − e^(−Rt/L)) / R, and its integral over the period.
    held = rise * inductance
    driven = (period - held) / resistance
    return np.array(
        [
            [decay - rise * gain, rise, rise * gain, -rise, 0.0],
            [-resistance * bandwidth * period, 1.0, resistance * bandwidth * period, 0.0, 0.0],
            [0.0, 0.0, 1.0, 0.0, 0.0],
            [0.0, 0.0, 0.0, 1.0, 0.0],
            [held - driven * gain, driven, driven * gain, -driven, 1.0],
        ]
    )


class PositionLoop:
    """PD on position; its velocity is the difference of the encoder over one period."""

    def __init__(self, parameters: ArmParameters) -> None:
        self._stiffness = np.asarray(parameters.stiffness)
        self._damping = np.asarray(parameters.damping)
        self._rate = parameters.position_rate
        self._before: Floats | None = None

    def reset(self) -> None:
        """Drop the last position."""
        self._before = None

    def torque(self, q_ref: Floats, qd_ref: Floats, position: Floats) -> Floats:
        """Return (6,) N·m for a reference and a measured position; call at the rate of the loop."""
        before = position if self._before is None else self._before
        velocity = (position - before) * self._rate
        self._before = position
        return self._stiffness * (q_ref - position) + self._damping * (qd_ref - velocity)


class SensorEffect(Protocol):
    """A fault between the true values and the sensors, perhaps with a state."""

    def reset(self) -> None:
        """Reset the state, if any."""
        return

    def sense(self, time: float, position: Floats, effort: Floats) -> tuple[Floats, Floats]:
        """Return the values that reach the sensors; called once a sample.

        Args:
            time: s since the reset.
            position: (6,) rad of the motors through the gears.
            effort: (6,) N·m of the motors through the gears.

        Returns:
            Position and effort as the encoders and the current sensors see them.
        """


class Sensors:
    """Encoders on the motors and current sensors, sampled together.

    Args:
        parameters: resolution, rate and noise.
        seed: of the noise.
        effects: faults that change the true values before sampling, in this order.
    """

    def __init__(
        self, parameters: ArmParameters, seed: int, effects: Sequence[SensorEffect] = ()
    ) -> None:
        self._effects = tuple(effects)
        self._step = parameters.encoder_step
        self._torque_per_ampere = parameters.torque_per_ampere
        self._noise = np.asarray(parameters.current_noise)
        self._rate = parameters.sample_rate if parameters.velocity_measured else np.nan
        self._tick = parameters.tick
        self._seed = seed
        self.reset()

    def reset(self) -> None:
        """Start again, with the same noise."""
        self._random = np.random.default_rng(self._seed)
        self._noises: Iterator[Floats] = iter(())
        self._before: Floats | None = None
        self._ticks = 0
        for effect in self._effects:
            effect.reset()

    def sample(self, q: Floats, current: Floats) -> tuple[Floats, Floats, Floats]:
        """Return measured position (6,) rad, velocity (6,) rad/s and effort (6,) N·m."""
        if self._effects:
            q, current = self._falsified(q, current)
        position = np.rint(q / self._step) * self._step
        before = position if self._before is None else self._before
        velocity = (position - before) * self._rate
        self._before = position
        return position, velocity, (current + self._next_noise()) * self._torque_per_ampere

    def _next_noise(self) -> Floats:
        """Return (6,) A; drawn for many samples at once, in the order of the samples."""
        noise = next(self._noises, None)
        if noise is None:
            drawn = self._random.standard_normal((NOISES, len(self._noise)))
            self._noises = iter(self._noise * drawn)
            noise = next(self._noises)
        return noise

    def _falsified(self, q: Floats, current: Floats) -> tuple[Floats, Floats]:
        effort = current * self._torque_per_ampere
        for effect in self._effects:
            q, effort = effect.sense(self._ticks * self._tick, q, effort)
        self._ticks += 1
        return q, effort / self._torque_per_ampere
