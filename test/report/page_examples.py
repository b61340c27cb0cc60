"""Records as compare, diagnose and history make them, small."""

from copy import deepcopy
from typing import Any

import numpy as np

SCRIPT = "</script><b>"
"""What a careless page would take for its own."""


def bins(joint: str, coordinate: str, levels: tuple[float, ...] = ()) -> dict[str, Any]:
    """A residual that grows with the coordinate."""
    edges = np.linspace(-1.0, 1.0, 7)
    low = list(levels) or [float(v) for v in edges[:-1]]
    high = list(levels) or [float(v) for v in edges[1:]]
    size = len(low)
    mean = [0.5 * v for v in low]
    return {
        "joint": joint, "coordinate": coordinate, "unit": "" if levels else "rad/s",
        "label": coordinate.replace("_", " "), "explained": 0.3, "low": low, "high": high,
        "mean": mean, "mean_low": [v - 0.1 for v in mean], "mean_high": [v + 0.1 for v in mean],
        "rms": [0.5] * size, "share_of_error": [1.0 / size] * size,
        "share_of_time": [1.0 / size] * size,
    }  # fmt: skip


def compared() -> dict[str, Any]:
    """A record of compare with the series: elbow fails at low speed."""
    time = [0.1 * k for k in range(60)]
    joints = ("shoulder", "elbow")
    return {
        "model": f"model{SCRIPT}.npz", "source": "a bag", "sources": ["a bag"], "samples": 600,
        "joints": {"shoulder": {"rmse": 0.5, "nmse": 0.01}, "elbow": {"rmse": 1.5, "nmse": 0.09}},
        "rmse": 1.1, "nmse": 0.05, "outside_range": 0.125, "too_short": False,
        "regions": [
            {
                "joint": "elbow", "coordinate": "velocity", "low": -0.1, "high": 0.1, "also": [],
                "share_of_error": 0.41, "share_of_time": 0.06, "place": "below 0.10 rad/s",
                "words": "elbow below 0.10 rad/s: 41 % of its error in 6 % of the time",
            }
        ],
        "evenly": ["shoulder"], "words": [],
        "blocks": [
            {"begin": 3.0 * k, "end": 3.0 * k + 3.0, "joints": {"shoulder": 0.5, "elbow": 1.5}}
            for k in range(2)
        ],
        "bins": [
            one
            for joint in joints
            for one in (bins(joint, "velocity"), bins(joint, "direction", (-1.0, 1.0)))
        ],
        "spectra": [
            {
                "joint": "elbow", "resolution": 2.0, "order": [2.0, 3.0, 20.0],
                "amplitude": [0.1, 0.1, 0.8], "noise": [0.2, 0.2, 0.2],
                "lines": [{"order": 20.0, "amplitude": 0.8, "share": 0.2}],
            }
        ],
        "outside": {"share_of_time": 0.125, "joints": {}},
        "series": {
            "time": time, "segment": [0] * 30 + [1] * 30,
            "joints": {
                joint: {"measured": [2.0 * t for t in time], "predicted": [1.5 * t for t in time]}
                for joint in joints
            },
        },
    }  # fmt: skip


def finding(effect: str, verdict: str, **more: Any) -> dict[str, Any]:
    """An effect on the elbow with everything a finding may hold."""
    return {
        "effect": effect, "joints": ["elbow"], "verdict": verdict, "evidence_gain": 213.0,
        "p_value": 0.01, "error_before": 1.5, "error_after": 0.9,
        "blocks": [
            {"time": 1.5, "before": 1.6, "after": 0.8}, {"time": 4.5, "before": 1.0, "after": 1.1},
        ],
        "parameters": {"F_s": {"value": 1.25, "low": 1.0, "high": 1.5, "unit": "N·m"}},
        "shape": {"v_s": 0.1}, "shape_words": {"v_s": "0.1"}, "formula": f"F_s sign(qd) {SCRIPT}",
        "meaning": "friction that is greater at low speed", "ambiguous_with": [],
        "next_motion": "a slow sweep of speeds",
        "signature": {
            "coordinate": "velocity", "unit": "rad/s", "x": [-1.0, 0.0, 1.0],
            "residual": [-1.0, 0.1, 1.0], "low": [-1.2, 0.0, 0.8], "high": [-0.8, 0.2, 1.2],
            "effect": [-1.0, 0.0, 1.0],
        },
        **more,
    }  # fmt: skip


def changed(what: str, **more: Any) -> dict[str, Any]:
    """A change of the elbow since the model was identified."""
    return {
        "what": what, "joints": ["elbow"], "evidence_gain": 90.0, "p_value": 0.0025,
        "change": {"m": {"value": 0.5, "unit": "kg", "low": 0.4, "high": 0.6}}, "size": 1.5,
        "rivals": [], **more,
    }  # fmt: skip


def diagnosed() -> dict[str, Any]:
    """A record of diagnose with one confirmed and one ambiguous finding."""
    return deepcopy(
        {
            "model": "model.npz", "sources": ["a bag"],
            "verdict": "elbow misses Stribeck friction of 1.2 N·m (confirmed). It may hold more.",
            "findings": [
                finding("stribeck", "confirmed"),
                finding(
                    "torque_ripple", "ambiguous with gear_mesh, spring", signature=None, blocks=[],
                    ambiguous_with=["gear_mesh", "spring"],
                ),
            ],
            "ranking": [
                {"effect": "stribeck", "joint": "elbow", "gain": 213.0, "threshold": 14.0},
                {"effect": "delay", "joint": "elbow", "gain": 3.0, "threshold": 14.0},
            ],
            "null": {"threshold": 14.0, "level": 0.05},
            "steps": [{"added": None, "error": 1.5}, {"added": "stribeck on elbow", "error": 0.9}],
            "unexplained": [{"joint": "shoulder", "coordinate": "position", "share": 0.19}],
            "not_observable": [
                {"effect": "rotor_inertia", "joint": "elbow", "next_motion": "two payloads"}
            ],
            "preflight": [
                {
                    "check": "saturation", "joint": "elbow", "finding": "clipped at 1.2 N·m",
                    "serious": True, "advice": "leave these samples out",
                }
            ],
            "compare": compared(),
        }
    )  # fmt: skip


def lineage() -> dict[str, Any]:
    """A record of history with one step."""
    return {
        "model": "model.npz",
        "steps": [
            {
                "added": "identified", "why": "", "when": "2026-01-02T03:04:05",
                "error_before": None, "error_after": 2.0,
                "joints": {"shoulder": {"before": None, "after": 0.5},
                           "elbow": {"before": None, "after": 2.0}},
                "evidence_gain": None, "p_value": None, "verdict": None, "judged_on": "a bag",
            },
            {
                "added": "torque_ripple on joint_2", "why": "a wave of 20 to a turn",
                "when": "2026-01-02T04:04:05", "error_before": 2.0, "error_after": 1.0,
                "joints": {"shoulder": {"before": 0.5, "after": 0.5},
                           "elbow": {"before": 2.0, "after": 1.0}},
                "evidence_gain": 41.0, "p_value": 0.0, "verdict": "confirmed",
                "judged_on": "another bag",
            },
        ],
    }  # fmt: skip
