"""Plans: the torques along a reference, faded or refused where unknown; the newest wins."""

import threading
from dataclasses import replace

import numpy as np
import pytest
from fake_model import FakeModel, Floats

from lagrangian_ff.identification.predicting import Terms
from lagrangian_ff.nodes.streaming.plan import CHUNK, STEP, Plan, Planner, Policy, make_plan, reason
from lagrangian_ff.nodes.streaming.ranges import excess
from lagrangian_ff.nodes.streaming.reference import Reference, RefusedReference

MODEL = FakeModel()
ALL = np.ones(4)
SCALE = np.ones(2)
LIMIT = np.full(2, 1000.0)


def swing(amplitude: float = 1.0, step: float = 0.05) -> Reference:
    """Return one swing of both joints, at rest at its ends."""
    time = np.arange(0.0, 2.0 + 1e-9, step)
    w = np.pi
    q = amplitude * 0.5 * (1.0 - np.cos(w * time))
    qd = amplitude * 0.5 * w * np.sin(w * time)
    qdd = amplitude * 0.5 * w**2 * np.cos(w * time)
    q, qd, qdd = (np.column_stack([x, -x]) for x in (q, qd, qdd))
    return Reference(("a", "b"), time, q, qd, qdd)


def plan_of(reference: Reference, policy: Policy | None = None) -> Plan:
    return make_plan(MODEL, reference, policy or Policy("allow"))


@pytest.mark.parametrize("count", [2, CHUNK, CHUNK + 1, 501])
def test_the_sum_of_the_parts_is_the_prediction(count: int) -> None:
    whole = swing(step=STEP)
    names = ("time", "q", "qd", "qdd")
    plan = plan_of(replace(whole, **{name: getattr(whole, name)[:count] for name in names}))
    assert len(plan.time) == count
    states = plan.reference.sample(plan.time)
    np.testing.assert_allclose(plan.parts.sum(axis=1), MODEL.predict(*states), atol=1e-12)


def test_samples_are_close_together_and_hold_the_own_points() -> None:
    plan = plan_of(swing())
    assert np.diff(plan.time).max() <= STEP + 1e-9
    np.testing.assert_allclose(plan.time[plan.own], plan.reference.time)
    assert len(plan_of(swing(step=STEP)).time) == 501


def test_effort_is_the_prediction_at_the_points_within_its_limit() -> None:
    reference = swing()
    plan = plan_of(reference)
    expected = MODEL.predict(reference.q, reference.qd, reference.qdd)
    own = plan.own
    np.testing.assert_allclose(plan.effort(ALL, SCALE, LIMIT)[own], expected, atol=1e-9)
    np.testing.assert_allclose(
        plan.effort(ALL, np.array([0.5, 0.0]), LIMIT)[own], expected * [0.5, 0.0], atol=1e-9
    )
    assert np.abs(plan.effort(ALL, SCALE, np.full(2, 3.0))).max() == 3.0
    gravity = plan.effort(np.array([1.0, 0.0, 0.0, 0.0]), SCALE, LIMIT)[own]
    np.testing.assert_allclose(gravity, 10.0 * np.cos(reference.q), atol=1e-9)


def test_an_effect_is_switched_with_what_it_is_like() -> None:
    """Friction off drops what dissipates, and keeps springs, rotors and offsets."""

    class Sprung(FakeModel):
        def terms(self, q: Floats, qd: Floats, qdd: Floats) -> Terms:
            terms = super().terms(q, qd, qdd)
            more = {"spring": 4.0 * q, "rotor_inertia": 0.7 * qdd, "stribeck": 0.1 * np.sign(qd)}
            return replace(terms, effects={**terms.effects, **more})

    plan = make_plan(Sprung(), swing(), Policy("allow"))
    q, qd, qdd = plan.reference.q, plan.reference.qd, plan.reference.qdd
    for number, expected in enumerate(
        (
            10.0 * np.cos(q) + 4.0 * q,
            2.7 * qdd,
            0.3 * qd**2,
            0.5 * qd + np.tanh(qd / 0.01) + 0.1 * np.sign(qd),
        )
    ):
        alone = plan.effort(np.eye(4)[number], SCALE, LIMIT)[plan.own]
        np.testing.assert_allclose(alone, expected, atol=1e-9)


def test_looking_up_interpolates_and_holds_the_ends_at_rest() -> None:
    plan = plan_of(swing())
    parts, weight = plan.at(0.7531)
    states = plan.reference.sample(np.array([0.7531]))
    np.testing.assert_allclose(parts.sum(axis=0), MODEL.predict(*states)[0], atol=1e-3)
    assert weight == 1.0
    for elapsed, q in ((-0.5, [0.0, 0.0]), (2.5, [0.0, 0.0])):
        held, _ = plan.at(elapsed)
        np.testing.assert_allclose(held[0], 10.0 * np.cos(q))
        assert not held[1:].any()
    np.testing.assert_allclose(plan.at(2.0)[0], plan.parts[-1])


def test_refuse_names_joint_quantity_time_and_range() -> None:
    make_plan(MODEL, swing(2.0), Policy("refuse", margin=0.1))
    with pytest.raises(RefusedReference) as refusal:
        make_plan(MODEL, swing(3.0), Policy("refuse", margin=0.1))
    text = str(refusal.value)
    assert "velocity of" in text
    assert "between -3 and 3 rad/s" in text


def test_fade_has_no_torque_outside_and_all_of_it_far_inside() -> None:
    reference = swing(3.0)
    plan = plan_of(reference, Policy("fade", margin=0.1, fade_time=0.2))
    states = reference.sample(plan.time)
    outside = excess(reference.joints, plan.time, states, MODEL.range, 0.1).outside
    assert outside.any()
    assert not plan.weight[outside].any()
    assert plan.weight[0] == 1.0
    assert np.abs(np.diff(plan.weight)).max() <= 0.004 / 0.2 + 1e-9


def test_allow_lets_everything_through_and_says_what_is_outside() -> None:
    plan = plan_of(swing(3.0))
    assert (plan.weight == 1.0).all()
    assert plan.excess.worst


def test_a_model_that_gives_no_number_is_refused() -> None:
    class Broken(FakeModel):
        def terms(self, q, qd, qdd):  # type: ignore[no-untyped-def]
            return super().terms(np.where(q > 0.9, np.nan, q), qd, qdd)

    with pytest.raises(RefusedReference, match="no finite torque"):
        make_plan(Broken(), swing(), Policy("allow"))


class GatedModel(FakeModel):
    """Computes only while the gate is open, and says when it has begun."""

    gate = threading.Event()
    begun = threading.Event()

    def terms(self, q: Floats, qd: Floats, qdd: Floats) -> Terms:
        self.begun.set()
        assert self.gate.wait(10.0)
        return super().terms(q, qd, qdd)


class Results:
    def __init__(self) -> None:
        self.plans: list[tuple[Plan, str]] = []
        self.errors: list[Exception] = []
        self.some = threading.Event()

    def done(self, plan: Plan, tag: str) -> None:
        self.plans.append((plan, tag))
        self.some.set()

    def failed(self, error: Exception) -> None:
        self.errors.append(error)
        self.some.set()


def reference(q: float = 0.5) -> Reference:
    still = np.zeros((2, 2))
    return Reference(("a", "b"), np.array([0.0, 1.0]), np.full((2, 2), q), still, still)


def test_a_newer_reference_takes_the_place_of_one_under_way() -> None:
    model, results = GatedModel(), Results()
    planner: Planner[str] = Planner(model, results.done, results.failed)
    planner.submit(lambda: (reference(), "old"), Policy())
    assert model.begun.wait(10.0)
    planner.submit(lambda: (reference(), "new"), Policy())
    model.gate.set()
    assert results.some.wait(10.0)
    planner.stop()
    assert [tag for _, tag in results.plans] == ["new"]
    assert not results.errors
    assert planner.fraction == 1.0


def test_what_is_dropped_never_comes_out() -> None:
    model, results = GatedModel(), Results()
    model.gate.clear()
    model.begun.clear()
    planner: Planner[str] = Planner(model, results.done, results.failed)
    planner.submit(lambda: (reference(), "dropped"), Policy())
    assert model.begun.wait(10.0)
    planner.drop()
    model.gate.set()
    planner.stop()
    assert not results.plans
    assert not results.errors


def test_a_refusal_is_reported_and_the_next_reference_planned() -> None:
    results = Results()
    planner: Planner[str] = Planner(FakeModel(), results.done, results.failed)
    planner.submit(lambda: (reference(9.0), "outside"), Policy("refuse"))
    assert results.some.wait(10.0)
    results.some.clear()
    planner.submit(lambda: (reference(), "inside"), Policy("refuse"))
    assert results.some.wait(10.0)
    planner.stop()
    assert [tag for _, tag in results.plans] == ["inside"]
    assert "outside the identified range" in reason(results.errors[0])


def test_the_reason_names_what_is_no_mistake_of_the_user() -> None:
    assert reason(RefusedReference("too far")) == "too far"
    assert reason(ValueError("too far")) == "ValueError: too far"
