"""The study of experiments that decide: each arm from its first motion to the judgement."""

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from lagrangian_ff.arm import HOME, JOINTS, Trajectory, working_motion
from lagrangian_ff.diagnosis import apply, diagnose, with_consequences
from lagrangian_ff.diagnosis.excite import (
    Between,
    For,
    Limits,
    Question,
    Suspect,
    design,
    excite,
    limits_of,
)
from lagrangian_ff.diagnosis.results import Diagnosis, Found
from lagrangian_ff.diagnosis.search.bayes_factor import variance_inflation_of
from lagrangian_ff.diagnosis.whitening import fit_for
from lagrangian_ff.effects import EFFECTS
from lagrangian_ff.errors import ModelError, UserError
from lagrangian_ff.identification import Settings, identify
from lagrangian_ff.investigation import Investigation, Plan, investigate
from lagrangian_ff.investigation.motions import both, for_design
from lagrangian_ff.investigation.stretches import learned_and_unseen
from lagrangian_ff.record_json import finite
from lagrangian_ff.recording import Conditioning, Recording, concatenate, condition_alike
from lagrangian_ff.studies.decide.cases import BUDGET, DecideCase, cases
from lagrangian_ff.studies.decide.results import DecideResults
from lagrangian_ff.studies.decide.rig import Clearance, Done, SimulatedRig, arm_limits
from lagrangian_ff.studies.decide.sooner import errors
from lagrangian_ff.studies.formulas import CASES, Strange, judged
from lagrangian_ff.studies.hidden.study import Clock
from lagrangian_ff.studies.hidden.verdicts import Judgement, Outcome, Truth, judge
from lagrangian_ff.studies.study import Line, Study

USUAL = 30.0
"""s of the usual motion, and at most of the one that decides."""
MODEL = "auto+fri"


@dataclass(frozen=True)
class Decision:
    """A case of the study."""

    case: DecideCase

    @property
    def name(self) -> str:
        """Return the arm's name."""
        return self.case.name

    def run(self) -> Mapping[str, Any]:
        """Move the arm, and judge what comes out."""
        if self.case.group == "sooner":
            return {"group": "sooner", **errors(self.case.nuisances, self.case.seed, MODEL)}
        clock = Clock()
        limits = arm_limits()
        rig = SimulatedRig(self.case.nuisances, self.case.hidden, self.case.seed, limits)
        usual = self._usual()
        rig.size_along(usual)
        clock.lap("sizing")
        if self.case.group == "motion":
            found = self._motion(rig, usual, clock)
        else:
            found = self._investigated(rig, clock)
        hidden = self.case.hidden
        return {
            "group": self.case.group,
            "hidden": [hidden.effect, hidden.joint, hidden.size] if hidden else None,
            "size": rig.size,
            **found,
            "left": rig.left,
            "seconds_of": clock.laps,
        }

    def _usual(self) -> Trajectory:
        drawn = self.case.nuisances
        kind = "spline" if drawn.motion == "point-to-point" else drawn.motion
        pace = min(drawn.pace, 0.45)
        return working_motion(kind, USUAL, 0.0, pace, self.case.seed, drawn.parameters)

    def _truths(self) -> list[Truth]:
        hidden = self.case.hidden
        if hidden is None:
            return []
        acts = hidden.kind.acts_on(JOINTS.index(hidden.joint))
        return [Truth(tuple(hidden.kind.catalogue), tuple(JOINTS[n] for n in acts))]

    def _judged(self, findings: Sequence[Found]) -> Judgement:
        return judge(self._truths(), findings, self.case.nuisances.allowed)

    def _visible(self, rig: SimulatedRig, found: Diagnosis) -> float | None:
        """Return the visible part of the effect over the torque that is left unexplained."""
        if self.case.hidden is None:
            return None
        return rig.visible / float(found.noise[JOINTS.index(self.case.hidden.joint)])

    def _motion(self, rig: SimulatedRig, usual: Trajectory, clock: Clock) -> dict[str, Any]:
        """Return what the usual motion, the designed one and the template's decide."""
        hidden = self.case.hidden
        assert hidden is not None
        suspect = Suspect(hidden.effect, hidden.joint)
        first = rig.follow(usual)
        rig.left = 0  # the usual motion knows no limits
        before = _diagnosed([first])
        clock.lap("usual")
        known = self._judged(before.findings)
        made: dict[str, Any] = {"before": known.record()}
        if known.outcome is Outcome.RIGHT:
            return made
        question = _question(before, suspect)
        model = for_design(before, question)
        limits, start = faster(limits_of(model), arm_limits()), np.array(HOME)
        found = design(
            model,
            question,
            limits,
            start=start,
            seconds=USUAL,
            clear=Clearance(),
            seed=self.case.seed,
        )
        clock.lap("designing")
        template = excite(
            EFFECTS[hidden.effect].motion,
            JOINTS,
            limits,
            joint=hidden.joint,
            start=start,
            duration=USUAL,
        )
        for name, path in (("designed", found.reference), ("template", template)):
            # At equal time: a template that must be slower is cut.
            rows = slice(0, 1 + round(USUAL / (path.time[1] - path.time[0])))
            cut = Trajectory(path.time[rows], path.q[rows], path.qd[rows], path.qdd[rows], JOINTS)
            try:
                after = _diagnosed([first, rig.follow(cut)])
            except UserError as error:
                made[name] = {"failed": str(error)}
                continue
            gains = {
                (name, joint): one.log_bayes_factor
                for one in after.findings
                for name in (*one.rivals, one.effect.name)
                for joint in one.joints
            }
            ranked = {(one.name, one.joint): one.log_bayes_factor for one in after.waiting}
            key = suspect.effect, suspect.joint
            made[name] = {
                "seconds": float(cut.time[-1]),
                "visible": self._visible(rig, after),
                "judgement": self._judged(after.findings).record(),
                "nats": gains.get(key, ranked.get(key, 0.0)),
                "attainable": _attainable(after, (rig.done[0], rig.done[-1])),
            }
            clock.lap(name)
        made["expected"] = found.nats
        made["asked"] = type(question).__name__
        return made

    def _investigated(self, rig: SimulatedRig, clock: Clock) -> dict[str, Any]:
        """Return what an investigation finds, and how soon."""
        limits = arm_limits()
        # Of what no effect fits, the group `outside` tells.
        plan = Plan(
            limits,
            budget=BUDGET,
            model=MODEL,
            clear=Clearance(),
            unlisted=False,
            seed=self.case.seed,
        )
        story = investigate(rig, plan, lambda proposal: True)
        clock.lap("investigating")
        judgement = self._judged([one for one, _ in _tried(story)])
        promised = attainable = None
        last = story.turns[-1].diagnosis
        if self.case.hidden is not None and judgement.outcome is not Outcome.RIGHT:
            attainable = _attainable(last, rig.done)
            promised = self._promised(story)
            clock.lap("designing")
        return {
            "visible": self._visible(rig, last),
            "attainable": attainable,
            "promised": promised,
            "story": story.record(),
            "judgement": judgement.record(),
            "moved": story.seconds,
            "when": self._when(story),
            "error": [story.before_total, story.turns[-1].total if story.turns else None],
        }

    def _promised(self, story: Investigation) -> float | None:
        """Return the nats that a motion would give that is designed for what stayed hidden."""
        hidden = self.case.hidden
        assert hidden is not None
        question = For(Suspect(hidden.effect, hidden.joint))
        model = for_design(story.turns[-1].diagnosis, question)
        try:
            return design(
                model,
                question,
                both(arm_limits(), limits_of(model), np.array(HOME)),
                start=np.array(HOME),
                seconds=USUAL,
                size=hidden.size,
                clear=Clearance(),
                seed=self.case.seed,
            ).nats
        except ModelError:
            return None

    def _when(self, story: Investigation) -> float | None:
        """Return the s of motion after which the truth was named for good; None if never."""
        last, moved = None, 0.0
        for turn in story.turns:
            moved += turn.seconds
            right = self._judged(turn.confirmed).outcome is Outcome.RIGHT
            last = (last if last is not None else moved) if right else None
        return last


def faster(seen: Limits, allowed: Limits) -> Limits:
    """Return the positions that a model has seen, with the speeds that an arm is allowed.

    Usual motion is slow, and most effects show with speed; in other poses gravity is not known.
    """
    inside = both(allowed, seen, np.array(HOME))
    return replace(allowed, q_low=inside.q_low, q_high=inside.q_high)


def _tried(story: Investigation) -> Sequence[tuple[Found, Any]]:
    return story.turns[-1].diagnosis.tried if story.turns else ()


def _question(found: Diagnosis, suspect: Suspect) -> Question:
    """Return what a user asks who suspects an effect and reads a diagnosis."""
    for one in found.findings:
        names = {one.effect.name, *one.rivals}
        if one.joint == suspect.joint and suspect.effect in names and len(names) > 1:
            other = next(name for name in (one.effect.name, *one.rivals) if name != suspect.effect)
            return Between(suspect, Suspect(other, suspect.joint))
    return For(suspect)


def _diagnosed(recordings: Sequence[Recording]) -> Diagnosis:
    """Return what a model of the first part of each recording lacks."""
    found = _once_diagnosed(recordings, Conditioning())
    if (lag := found.lag) is not None:
        found = replace(_once_diagnosed(recordings, lag.applied(Conditioning())), lag=lag)
    return with_consequences(found)


def _once_diagnosed(recordings: Sequence[Recording], conditioning: Conditioning) -> Diagnosis:
    motions = condition_alike(list(recordings), conditioning)
    learned, unseen = learned_and_unseen(motions)
    model = identify(learned, Settings(model=MODEL, train=1.0)).model
    return diagnose(model, learned, unseen)


def _attainable(found: Diagnosis, moved: Sequence[Done]) -> float:
    """Return the nats that the hidden effect's true torque should gain beside all confirmed ones.

    Of the parts that are searched, with all that the model and the noise leave open, and tempered
    as every score is: no search can see more. What a gear does that no model holds comes in
    stretches, and counts as fewer independent blocks. An effect that was confirmed has nothing left
    to gain.
    """
    conditioning = found.model.identified.conditioning
    motions = condition_alike([one.recording for one in moved], conditioning)
    truths = [one.truth_of(motion) for one, motion in zip(moved, motions, strict=True)]
    motion, truth = (concatenate(learned_and_unseen(some)[0]) for some in (motions, truths))
    model = apply(found)
    white = fit_for(model, motion)
    tau = white.x.mean(truth.tau)
    z = white.project(white.shared(tau, np.eye(tau.shape[1]))).sum(axis=1)
    information = float(z @ z)
    rest = np.add.reduceat(z * (white.residual - z), white.starts)
    return 0.5 * information / float(variance_inflation_of(rest, information))


@dataclass(frozen=True)
class Unlisted:
    """An arm with physics outside the catalogue, that a curve and a formula are to hold."""

    case: Strange
    seed: int

    @property
    def name(self) -> str:
        """Return the name of the case."""
        return "outside-" + re.sub("[^a-z0-9]+", "_", self.case.name.lower()).strip("_")

    def run(self) -> Mapping[str, Any]:
        """Return the errors with the curve, the formula and the truth, and the formulas."""
        found = judged(self.case, self.seed)
        return finite({"group": "outside", **asdict(found), "over": list(self.case.over)})


def _group(case: Decision | Unlisted) -> str:
    return case.name.partition("-")[0]


class DecideStudy(Study):
    """Do designed motions decide what usual ones leave open, and does an investigation find it?"""

    name = "decide"

    def every_case(self) -> Sequence[Decision]:
        """Return the cases, all groups evenly mixed: a study that is cut short has some of each."""
        seed, quick = self.request.seed, self.request.quick
        every: list[Decision | Unlisted] = [Decision(one) for one in cases(seed, small=quick)]
        every += [Unlisted(one, seed) for one in (CASES[:1] if quick else CASES)]
        counts, met = Counter(map(_group, every)), Counter[str]()
        places: list[float] = []
        for one in every:
            met[_group(one)] += 1
            places.append((met[_group(one)] - 0.5) / counts[_group(one)])
        return [every[k] for k in np.argsort(places, kind="stable")]

    def results(self, lines: Sequence[Line]) -> DecideResults:
        return DecideResults.of(lines)
