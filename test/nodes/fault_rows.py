"""The table of faults: what the torque does at each, within which time, what /diagnostics says.

The table in docs/feedforward.md is written from this list (`python tools/doc_tables.py`), and
test_fault_table.py injects each row.
"""

from dataclasses import dataclass
from enum import Enum
from itertools import groupby

DEFAULTS = {
    "reference_timeout": 0.2,
    "joint_state_timeout": 0.5,
    "fade_time": 0.5,
    "ramp_time": 0.5,
    "watchdog timeout": 0.1,
    "watchdog fade_time": 0.5,
}
"""s, of the parameters that times are given in."""


class Torque(Enum):
    """What the torque does."""

    ZERO = "fades to zero"
    GOES_ON = "goes on as it is"
    NEVER = "none is sent"
    STOPS = "no message comes: **the controller holds the last torque**"
    OTHER = "moves to another torque within its limits"


@dataclass(frozen=True)
class Row:
    """One fault.

    Attributes:
        key: of the function that injects it.
        of: the part of the system it befalls.
        fault: what happens.
        torque: what the torque does.
        within: the parameters whose sum is the time this takes, besides a tick.
        says: a regular expression that /diagnostics then matches; what the table shows of it.
        more: a sentence beside what the torque does.
        at_most: s that it takes instead; 0 = see `within`.
        when: what the table shows of the time instead.
    """

    key: str
    of: str
    fault: str
    torque: Torque
    says: str
    within: tuple[str, ...] = ()
    more: str = ""
    at_most: float = 0.0
    when: str = ""

    def seconds(self, settings: dict[str, float]) -> float:
        """Return the time it takes with these settings, s."""
        return self.at_most or sum(settings[name] for name in self.within)


REFERENCE, STATES, TIME = "reference", "joint states", "time"
MODEL, PROCESS, USER = "model file", "process", "what a user asks for"
SILENT = ("joint_state_timeout", "fade_time")
GUARDED = ("watchdog timeout", "watchdog fade_time")
ZERO, GOES_ON, NEVER, STOPS, OTHER = Torque

ROWS = (
    Row("stops", REFERENCE, "set-points stop", ZERO, "no set-point for",
        ("reference_timeout", "fade_time")),
    Row("jumps", REFERENCE, "jumps by less than `tracking_tolerance`", OTHER,
        "ticks at the rate limit: [1-9]", more="at the rate limit", at_most=0.1),
    Row("jumps_far", REFERENCE, "jumps farther from the robot than `tracking_tolerance`", ZERO,
        "more than 0.5 rad from its reference", ("fade_time",)),
    Row("nan", REFERENCE, "holds NaN", GOES_ON,
        "refused a reference: the position of b in point 1 is nan"),
    Row("infinite", REFERENCE, "holds an infinite number", GOES_ON,
        "the position of b in point 1 is inf"),
    Row("sizes", REFERENCE, "rows of wrong lengths", GOES_ON,
        "point 1 has 3 position values for 2 joints"),
    Row("names", REFERENCE, "other joints", GOES_ON, "no joint b; it moves a, c"),
    Row("unsorted", REFERENCE, "times that do not increase", GOES_ON,
        "time_from_start must increase"),
    Row("empty", REFERENCE, "no points", GOES_ON, "0 points; expected 1 to"),
    Row("past", REFERENCE, "is over already", GOES_ON, "it ended .* s ago"),
    Row("junk", REFERENCE, "bytes that are no trajectory", GOES_ON, "refused a reference: .*Error"),
    Row("many", REFERENCE, "100,000 points", GOES_ON, "100000 points; expected 1 to 20000"),
    Row("sparse", REFERENCE, "two points, seconds apart", OTHER, "following",
        more="along a spline between them", when="as the motion goes"),
    Row("outside", REFERENCE, "outside what was identified (`out_of_range: fade`)", ZERO,
        "the model was identified between", ("fade_time",),
        "a trajectory fades before it leaves"),
    Row("limit", REFERENCE, "asks for more than the torque limit", OTHER,
        "torque limit reached in", more="to the limit", at_most=0.1),
    Row("silent", STATES, "stop", ZERO, "no joint states for", SILENT),
    Row("stale", STATES, "go on with the stamp of an old one", ZERO, "repeats an old state",
        SILENT),
    Row("two_publishers", STATES, "come from two publishers, not in order", GOES_ON,
        "not in the order of their stamps"),
    Row("other_arm", STATES, "are those of another arm", ZERO,
        "no joint states of the model's joints, though", SILENT),
    Row("part", STATES, "lack a joint of the model", ZERO, "joint states without b", SILENT),
    Row("nan_states", STATES, "hold NaN", ZERO, "the position of b is not finite", SILENT),
    Row("astray", STATES, "jump away from the reference", ZERO, "from its reference",
        ("fade_time",)),
    Row("hour_off", STATES, "are stamped an hour off", GOES_ON,
        "3600.. s ahead of this node's clock",
        more="the time of arrival counts"),
    Row("set_back", STATES, "jump back in time by a minute", GOES_ON, "went back in time"),
    Row("no_clock", TIME, "`use_sim_time` and nobody publishes `/clock`", NEVER,
        "nobody publishes /clock"),
    Row("clock_back", TIME, "the simulated clock is set back", ZERO, "the clock was set back by",
        ("fade_time",), "in simulated time"),
    Row("clock_stands", TIME, "the simulated clock stands", STOPS, "simulated time stands at"),
    Row("missing", MODEL, "missing at the start", NEVER, "missing.npz"),
    Row("broken", MODEL, "truncated at the start", NEVER, "broken.npz"),
    Row("truncated", MODEL, "truncated while active", GOES_ON, "stays in use: .*model.npz"),
    Row("other_joints", MODEL, "of other joints while active", GOES_ON,
        "stays in use: .* is a model of a, c"),
    Row("removed", MODEL, "removed while active", GOES_ON, "stays in use: .*model.npz"),
    Row("replaced", MODEL, "replaced while active", OTHER, "loaded", more="over `ramp_time`, when "
        "it is loaded and checked", at_most=5.0),
    Row("bad_parameter", USER, "a parameter out of its range, at run time", GOES_ON, "",
        more="the caller is answered with the reason"),
    Row("bad_start", USER, "a parameter out of its range, at the start", NEVER, "",
        more="the node ends with one sentence"),
    Row("not_allowed", USER, "a transition that is impossible now", GOES_ON, "",
        more="the caller is answered: success false"),
    Row("disabled", USER, "`~/enable` false", ZERO, "disabled", ("fade_time",)),
    Row("deactivated", USER, "deactivated", ZERO, "not active", ("fade_time",)),
    Row("starved", PROCESS, "too little processor time", GOES_ON, "Hz instead of 500 Hz",
        more="or fades, where set-points or joint states come too late; after a stall it makes up "
        "for three periods at most"),
    Row("stopped", PROCESS, "SIGSTOP, then SIGCONT", STOPS, "Hz instead of 500 Hz",
        more="until SIGCONT; then it goes on from there"),
    Row("stopped_guarded", PROCESS, "the same, behind the watchdog", ZERO,
        "is the feedforward alive", GUARDED, "until SIGCONT, then it is brought in"),
    Row("killed", PROCESS, "`kill -9`", STOPS, ""),
    Row("killed_guarded", PROCESS, "`kill -9`, behind the watchdog", ZERO,
        "is the feedforward alive", GUARDED),
    Row("restarted", PROCESS, "killed and started in mid-trajectory", OTHER, "following",
        more="zero, until the reference is sent again; then it joins the motion along the ramp",
        when="its start, then `ramp_time`"),
    Row("late", PROCESS, "it is found after a reference was sent", NEVER, "no reference",
        more="only zeros, until the next reference"),
    Row("second", PROCESS, "a second node of its name", GOES_ON, "2 nodes are called /feedforward",
        more="but both send, and the controller gets the two in turn"),
    Row("neighbour", PROCESS, "another arm's node, in its namespace, is killed", GOES_ON,
        ""),
    Row("ended", PROCESS, "SIGINT, SIGTERM, SIGHUP or SIGQUIT, once or twice", ZERO, "",
        ("fade_time",), "last zeros are sent"),
    Row("guard_ended", PROCESS, "the watchdog is ended by a signal", ZERO, "",
        ("watchdog fade_time",), "last zeros are sent"),
    Row("guard_killed", PROCESS, "`kill -9` of the watchdog", STOPS, ""),
)  # fmt: skip


def table() -> str:
    """Return the table in Markdown."""
    lines = [
        "| what | fault | the torque | within | `/diagnostics` says |",
        "|---|---|---|---|---|",
    ]
    for of, rows in groupby(ROWS, key=lambda row: row.of):
        for k, row in enumerate(rows):
            torque = row.torque.value + (f"; {row.more}" if row.more else "")
            within = row.when or " + ".join(f"`{name}`" for name in row.within)
            if seconds := row.seconds(DEFAULTS):
                within += f" ({seconds:g} s)" if within else f"{seconds:g} s"
            says = row.says.replace(".*", "…").replace("..", ".0").replace("[1-9]", "n")
            lines.append(
                f"| {'' if k else of} | {row.fault} | {torque} | {within or '–'} | {says} |"
            )
    return "\n".join(lines)
