"""What was found out about a model, as statuses and as lines of the log."""

from collections.abc import Callable, Mapping
from typing import Any, Protocol

from lagrangian_ff.nodes.common.status import Level, Status
from lagrangian_ff.nodes.common.summary import held_out
from lagrangian_ff.nodes.common.summary import lines as identified
from lagrangian_ff.nodes.recorder.order import Order, Task
from lagrangian_ff.nodes.recorder.session import CONFIRMED, Session

NAMES = {
    Task.IDENTIFY: "identification",
    Task.COMPARE: "comparison",
    Task.DIAGNOSE: "diagnosis",
    Task.ADD: "addition",
}
"""Of the statuses."""

REGIONS = 8
"""Sentences about where a model fails that are told; the page has all."""
LEAVING = 0.05
"""Share of a motion outside the identified range from which on it is warned of."""


class Progressing(Protocol):
    """Work under way: its order, the share done, and what it does now."""

    @property
    def order(self) -> Order: ...
    @property
    def fraction(self) -> float: ...
    @property
    def label(self) -> str: ...


def work_status(task: Task, session: Session, job: Progressing | None) -> dict[str, Status]:
    """How this kind of work stands; nothing where there was none, but for the identification."""
    name = NAMES[task]
    if job is not None and job.order.task is task:
        state = session.state.value
        values = {"state": state, "progress": job.fraction, "label": job.label}
        return {name: Status(Level.OK, f"{state}: {job.label}", values)}
    if task is Task.IDENTIFY:
        return {name: identification_status(session)}
    if task in session.failures:
        return {name: Status(Level.ERROR, f"{name} failed: {session.failures[task]}", {})}
    if task in session.found:
        return {name: STATUSES[task](session.found[task])}
    return {}


def identification_status(session: Session) -> Status:
    """The present model, and its error on held-out motion."""
    values: dict[str, object] = {"state": session.state.value, "recordings": len(session.bags)}
    if session.result is not None:
        record = session.result.record
        values |= {
            "model file": session.result.model,
            "model": record["model"],
            "held-out RMSE [N·m]": record["rmse"],
            "held-out nMSE": record["nmse"],
            **held_out(record),
        }
    failure = session.failures.get(Task.IDENTIFY)
    if failure:
        return Status(Level.ERROR, f"identification failed: {failure}", values)
    return Status(Level.OK, "identified" if session.result else "no model yet", values)


def lines(order: Order, record: Mapping[str, Any]) -> list[str]:
    """What to log at the end of an order."""
    if order.task is Task.IDENTIFY:
        return [*identified(record), f"  model file: {order.output}"]
    told = [STATUSES[order.task](record).message]
    if order.task is Task.COMPARE:
        told += [f"  {text}" for text in record["words"][:REGIONS]]
    if order.task is Task.DIAGNOSE:
        told += [f"  {_name(one)}: {_finding(one).message}" for one in record["findings"]]
    if order.task is Task.ADD:
        told.append(f"  model file: {order.output}")
    return told + [f"  {label}: {file}" for label, file in _files(record).items()]


def comparison_status(record: Mapping[str, Any]) -> Status:
    """Where the model fails; a warning where the motion leaves what the model knows."""
    words = record["words"]
    outside = record["outside_range"]
    values: dict[str, object] = {
        "model": record["model"],
        "recordings": ", ".join(record["sources"]),
        "RMSE [N·m]": record["rmse"],
        "nMSE": record["nmse"],
        **{
            f"error {joint}": f"{error['rmse']:.4g} N·m, nMSE {error['nmse']:.4g}"
            for joint, error in record["joints"].items()
        },
        "outside the identified range": f"{outside:.1%}",
        **{f"where {number}": text for number, text in enumerate(words[:REGIONS], 1)},
        **_files(record),
    }
    message = f"{record['rmse']:.4g} N·m; " + (words[0] if words else "the error is spread evenly")
    if outside > LEAVING:
        return Status(
            Level.WARN,
            f"{message}; {outside:.0%} of the motion lies outside what the model was identified on",
            values,
        )
    return Status(Level.OK, message, values)


def diagnosis_status(record: Mapping[str, Any]) -> Status:
    """The verdict; a warning where something is missing in the model, or wrong with the
    measurement: that looks like missing physics and is to be mended first."""
    missing = record["findings"] or record["unexplained"]
    serious = [_check(one) for one in record["preflight"] if one["serious"]]
    values: dict[str, object] = {
        "model": record["model"],
        "recordings": ", ".join([*record["sources"], *record["confirm"]]),
        "confirmed on": record["confirmed_on"],
        "findings": len(record["findings"]),
        "unexplained": len(record["unexplained"]),
        **{f"fix first {number}": text for number, text in enumerate(serious, 1)},
        "not observable": ", ".join(
            f"{one['effect']} on {one['joint']}" for one in record["not_observable"]
        ),
        **_files(record),
    }
    message = " ".join([*(f"Fix first: {text}" for text in serious), record["verdict"]])
    return Status(Level.WARN if missing or serious else Level.OK, message, values)


def finding_statuses(session: Session) -> dict[str, Status]:
    """One for each effect that is missing or may be, best first, then what has no name."""
    record = session.found.get(Task.DIAGNOSE)
    if record is None:
        return {}
    found = {_name(one): _finding(one) for one in record["findings"]}
    for one in record["unexplained"]:
        found[f"unexplained on {one['joint']}: {one['coordinate']}"] = Status(
            Level.WARN,
            f"the torque depends on {one['coordinate']} in a way that no known effect explains",
            {"joint": one["joint"], "share of the torque": one["share"]},
        )
    return found


def addition_status(record: Mapping[str, Any]) -> Status:
    """What was added, and what that did to the error on held-out motion.

    A model is refitted from the data that it keeps: what came into the arm later is not in them.
    """
    steps = record["steps"][-len(record["added"]) :]
    before, after = steps[0]["error_before"], steps[-1]["error_after"]
    message = (
        f"added {' and '.join(record['added'])}: error {before:.4g} to {after:.4g} N·m on "
        f"{steps[-1]['judged_on']}"
    )
    if not after < before:
        message += (
            "; it did not fall, the data that the model keeps do not show the effect: if it came "
            "later, identify again from the new recordings and add it then"
        )
    return Status(
        Level.OK if after < before else Level.WARN,
        message,
        {
            **{
                f"step {number}": f"{step['added']}: {step['error_after']:.4g} N·m"
                for number, step in enumerate(record["steps"], 1)
            },
            **_files(record),
        },
    )


STATUSES: Mapping[Task, Callable[[Mapping[str, Any]], Status]] = {
    Task.COMPARE: comparison_status,
    Task.DIAGNOSE: diagnosis_status,
    Task.ADD: addition_status,
}


def _finding(one: Mapping[str, Any]) -> Status:
    values: dict[str, object] = {
        "effect": one["effect"],
        "joints": ", ".join(one["joints"]),
        "verdict": one["verdict"],
        "evidence gain [nats]": float(one["evidence_gain"]),
    }
    # What happens once is not held against chance.
    if one["p_value"] is not None:
        values["p value"] = float(one["p_value"])
    for label, name in (
        ("error before [N·m]", "error_before"),
        ("error after [N·m]", "error_after"),
    ):
        if one[name] is not None:
            values[label] = float(one[name])
    for name, value in one["parameters"].items():
        values[name] = (
            f"{value['value']:.4g} {value['unit']} ({value['low']:.4g} to {value['high']:.4g})"
        )
    values |= {f"shape {name}": float(value) for name, value in one["shape"].items()}
    if one.get("reason"):
        values["not confirmed because"] = one["reason"]
    if one.get("told_apart_by"):
        values["told apart by"] = "; ".join(one["told_apart_by"])
    values["next motion"] = one["next_motion"]
    sure = one["verdict"] == CONFIRMED
    message = f"{one['verdict']}: {one['meaning']}"
    if sure and one["error_after"] is not None:
        message += f"; error {one['error_before']:.3g} to {one['error_after']:.3g} N·m when added"
    suggested = one["verdict"] == "suggested"
    return Status(Level.OK if suggested else Level.WARN, message, values)


def _check(one: Mapping[str, Any]) -> str:
    where = f"{one['joint']}: " if one["joint"] else ""
    return f"{where}{one['finding']}. {one['advice']}".strip()


def _name(one: Mapping[str, Any]) -> str:
    return f"{one['effect']} on {', '.join(one['joints'])}"


def _files(record: Mapping[str, Any]) -> dict[str, object]:
    named = {"JSON": "json", "page": "page", "no page because": "page_failure"}
    return {label: record[name] for label, name in named.items() if record.get(name)}
