"""Every hidden effect: its list, its size, what it does to the arm, and that it stays physics."""

import ast
from collections.abc import Callable
from contextlib import closing
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from arm_examples import bias
from scipy.ndimage import uniform_filter1d

import lagrangian_ff.arm.hidden
from lagrangian_ff.arm import HOME, JointMoment, Load, Plant, Run, exciting_trajectory, simulate
from lagrangian_ff.arm.body import Body
from lagrangian_ff.arm.hidden import HIDDEN, HiddenEffect, Installed, Reference, Site, size, sized
from lagrangian_ff.arm.hidden.base import ALL_JOINTS, replay
from lagrangian_ff.arm.hidden.solid import Bristles
from lagrangian_ff.arrays import Floats
from lagrangian_ff.effects import EFFECTS

MOTION = exciting_trajectory(6, 1, duration=4.0)
JOINT = 1


@pytest.fixture(scope="module")
def driven(site: Site) -> Callable[[str], tuple[Installed, Run]]:
    """Return what drives the arm with a tenth of an effect, or its largest, once for all tests."""

    @cache
    def drive(name: str) -> tuple[Installed, Run]:
        effect = HIDDEN[name]
        parts, _ = sized(effect, site, min(0.1, effect.largest))
        run = simulate(
            MOTION,
            effects=parts.effects,
            sensors=parts.sensors,
            gears=parts.gears,
            attached=parts.attached,
        )
        return parts, run

    return drive


@pytest.fixture(scope="module")
def clean() -> Run:
    return simulate(MOTION)


@pytest.fixture(scope="module")
def site(clean: Run) -> Site:
    return Site(JOINT, 5, 0, Reference.of(clean))


@pytest.fixture(params=HIDDEN)
def effect(request: pytest.FixtureRequest) -> HiddenEffect:
    return HIDDEN[request.param]


def test_the_right_answers_are_in_the_catalogue_of_effects() -> None:
    for effect in HIDDEN.values():
        assert set(effect.catalogue) <= set(EFFECTS), effect.name
    assert sum(bool(effect.catalogue) for effect in HIDDEN.values()) >= 14
    assert sum(not effect.catalogue for effect in HIDDEN.values()) >= 5


def test_the_physics_shares_no_code_with_what_is_to_find_it() -> None:
    folder = Path(lagrangian_ff.arm.hidden.__file__).parent
    for file in folder.glob("*.py"):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom):
                assert node.module is not None
                rooms = node.module.split(".")
                if rooms[0] == "lagrangian_ff":
                    # The names of array types are no physics.
                    assert rooms[1] in ("arm", "arrays"), f"{file.name} imports {node.module}"


@pytest.mark.parametrize("wanted", [0.02, 0.1])
def test_an_effect_gets_the_size_asked_for_or_its_strongest(
    effect: HiddenEffect, site: Site, wanted: float
) -> None:
    wanted = min(wanted, effect.largest)
    parts, strength = sized(effect, site, wanted)
    found = size(effect, parts, site)
    if strength == effect.strongest:
        assert found < wanted
    else:
        assert found == pytest.approx(wanted, rel=0.05)
    assert parts.facts
    assert all(np.isfinite(value) for value in parts.facts.values())


def test_the_same_seed_hides_the_same_physics(effect: HiddenEffect, site: Site) -> None:
    one, other = (effect.install(site, effect.start) for _ in range(2))
    assert one.facts == other.facts
    np.testing.assert_array_equal(effect.torque(one, site), effect.torque(other, site))


def test_recordings_of_one_arm_differ_in_what_happens_by_chance_alone(
    effect: HiddenEffect, site: Site
) -> None:
    other = Site(site.joint, site.seed, 1, site.along)
    one, two = effect.install(site, effect.start), effect.install(other, effect.start)
    by_chance = effect.name in ("shaking", "debris")
    same = np.array_equal(effect.torque(one, site), effect.torque(two, other))
    assert same is not by_chance


def test_an_effect_acts_where_it_says(effect: HiddenEffect, site: Site) -> None:
    torque = effect.torque(effect.install(site, effect.start), site)
    moved = {j for j in ALL_JOINTS if np.abs(torque[:, j]).max() > 1e-9}
    assert JOINT in moved
    if not effect.install(site, effect.start).sensors and effect.name not in (
        "elasticity",
        "backlash",
    ):
        assert moved <= set(effect.acts_on(JOINT))


@pytest.mark.parametrize(
    "name", ["stribeck", "load_friction", "hysteresis", "ripple", "coupled", "contact", "starved"]
)
def test_a_run_meets_the_torque_that_was_sized(
    name: str, site: Site, driven: Callable[[str], tuple[Installed, Run]]
) -> None:
    """The plant's own account of the effect, and the effect replayed along what happened."""
    parts, run = driven(name)
    again = replay(parts, Site(JOINT, site.seed, 0, Reference.of(run)))
    true = run.added_torque
    error = np.sqrt(np.mean((again - true) ** 2, axis=0))[JOINT]
    rms = np.sqrt(np.mean(true**2, axis=0))[JOINT]
    assert error < 0.15 * rms
    share = rms / np.sqrt(np.mean(run.motor_torque[:, JOINT] ** 2))
    assert share == pytest.approx(0.1, rel=0.35)


OF_EACH_KIND = (
    "hysteresis",
    "coupled",
    "backlash",
    "elasticity",
    "delay",
    "saturation",
    "eccentricity",
    "payload",
    "contact",
)


@pytest.mark.parametrize("name", OF_EACH_KIND)
def test_the_recording_changes_and_the_arm_still_tracks(
    name: str, clean: Run, driven: Callable[[str], tuple[Installed, Run]]
) -> None:
    _, run = driven(name)
    changed = run.recording.effort - clean.recording.effort
    noise = 160.0 * 0.0385 * 0.12
    assert np.abs(changed[:, JOINT]).max() > 3.0 * noise or not np.array_equal(
        run.recording.position, clean.recording.position
    )
    assert np.sqrt(np.mean(run.tracking_error**2)) < 0.05


DISSIPATES = (
    "stribeck",
    "load_friction",
    "load_viscous",
    "warm_up",
    "quadratic_drag",
    "power_law",
    "asymmetric_viscous",
    "coupled",
    "pitting",
    "capstan",
    "pinched",
    "debris",
    "starved",
)


@pytest.mark.parametrize("name", DISSIPATES)
def test_friction_never_gives_energy(name: str, site: Site) -> None:
    effect = HIDDEN[name]
    torque = effect.torque(sized(effect, site, 0.1)[0], site)
    power = np.sum(torque * site.along.qd, axis=1)
    assert power.min() >= -1e-9
    assert power.mean() > 0.0


@pytest.mark.parametrize("wanted", [0.05, 0.2])
def test_position_friction_stays_a_loss_with_the_joints_own(site: Site, wanted: float) -> None:
    effect = HIDDEN["position_friction"]
    torque = effect.torque(sized(effect, site, wanted)[0], site)
    v = site.along.qd[:, JOINT]
    plant = Plant()
    own = plant.friction.at(site.along.qd)[:, JOINT]
    plant.close()
    assert np.all((torque[:, JOINT] + own) * v >= -1e-9)


def test_bristles_carry_a_load_without_slipping_and_lose_energy_in_a_loop() -> None:
    slip, distance, dt = 2.0, 5e-3, 1e-3
    bristles = Bristles(0, slip, distance)
    bristles.reset(np.zeros(6))
    q = 2.0 * distance * np.sin(np.linspace(0.0, 6.0 * np.pi, 6000))
    torque, work = [], 0.0
    for k in range(1, len(q)):
        v = np.zeros(6)
        v[0] = (q[k] - q[k - 1]) / dt
        moment = JointMoment(k * dt, dt, np.full(6, q[k]), v, np.zeros(6), np.zeros(6))
        here, slope = bristles.torque(moment)
        assert slope[0] >= 0.0
        torque.append(here[0])
        work += here[0] * v[0] * dt
        bristles.advance(moment)
    assert np.abs(torque).max() <= slip
    # At first it is a spring of slip / distance.
    assert torque[3] == pytest.approx(slip / distance * q[4], rel=0.05)
    # Each of the three loops costs less than slip at full travel, and more than a third of it.
    travel = np.abs(np.diff(q)).sum()
    assert slip * travel / 3.0 < work < slip * travel


def test_warm_up_begins_cold_after_every_reset(site: Site) -> None:
    parts, _ = sized(HIDDEN["warm_up"], site, 0.1)
    first, second = (replay(parts, site) for _ in range(2))
    np.testing.assert_array_equal(first, second)
    plant = Plant()
    own = plant.friction.at(site.along.qd)[:, JOINT]
    plant.close()
    moving = np.abs(own) > 1.0
    share = first[moving, JOINT] / own[moving]
    assert share[0] == pytest.approx(parts.facts["share of own friction, cold"], rel=0.1)
    assert np.all(np.diff(share) < 1e-9)
    assert share[-1] < 0.9 * share[0]


def test_a_payload_is_there_from_its_time_on(clean: Run, site: Site) -> None:
    parts, _ = sized(HIDDEN["payload"], site, 0.2)
    begin = parts.facts["attached at [s]"]
    assert parts.attached is not None
    run = simulate(MOTION, attached=parts.attached)
    before = run.recording.time < begin
    np.testing.assert_array_equal(run.position[before], clean.position[before])
    gap = np.abs(run.motor_torque - clean.motor_torque)[~before]
    assert gap[100:, JOINT].max() > 0.1 * np.abs(clean.motor_torque[:, JOINT]).max()


def test_a_push_holds_the_arms_weight_by_virtual_work() -> None:
    """Gravity is a push too: a force of m g at the tool is borne like a load of m there."""
    q, still = np.array(HOME), np.zeros(6)
    with Body() as free:
        arm = free.tool_jacobian(q)
        held = bias(free, q, still)
    with Body({"link_6": Load(0.5, (0.0, 0.0, 0.0))}) as loaded:
        weight = bias(loaded, q, still) - held
    np.testing.assert_allclose(arm.T @ [0.0, 0.0, 0.5 * 9.81], weight, atol=1e-6)


@pytest.mark.parametrize("name", ["elasticity", "backlash"])
def test_a_soft_gear_has_the_torque_that_the_motors_motion_does_not_explain(
    name: str, site: Site, driven: Callable[[str], tuple[Installed, Run]]
) -> None:
    """Friction and rotor act on the motor's side, where the encoder is: they explain themselves."""
    parts, run = driven(name)
    here = Reference.of(run)
    torque = HIDDEN[name].torque(parts, Site(JOINT, site.seed, 0, here))[:, JOINT]
    rate = np.gradient(run.encoder, here.time, axis=0)
    with closing(Plant()) as plant:
        seen = plant.true_torque(run.encoder, rate, np.gradient(rate, here.time, axis=0))
    left = smooth(run.motor_torque[:, JOINT] - seen[:, JOINT])
    inner = slice(100, -100)
    plain = np.std(left[inner])
    assert np.std((left - smooth(torque))[inner]) < 0.5 * plain


def smooth(values: Floats, width: int = 61) -> Floats:
    """Return values averaged twice over a window: the servo's noise is fast."""
    return np.asarray(uniform_filter1d(uniform_filter1d(values, width), width))
