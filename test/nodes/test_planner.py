"""Plans are computed beside the stream, always for the newest reference."""

import threading

import numpy as np
from fake_model import FakeModel, FakeTerms, Floats

from lagrangian_ff.nodes.common.errors import RefusedReference
from lagrangian_ff.nodes.streaming.plan import Plan, Policy
from lagrangian_ff.nodes.streaming.planner import Planner, reason
from lagrangian_ff.nodes.streaming.reference import Reference


class HeldModel(FakeModel):
    """Computes only while the gate is open, and says when it has begun."""

    gate = threading.Event()
    begun = threading.Event()

    def terms(self, q: Floats, qd: Floats, qdd: Floats) -> FakeTerms:
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
    model, results = HeldModel(), Results()
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
    model, results = HeldModel(), Results()
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


def test_a_refusal_is_told_and_the_next_reference_planned() -> None:
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
