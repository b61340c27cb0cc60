"""What grows with the load, on a joint whose load is a guess.

The constant part of a joint's inertia may belong to the rotor, before the gear, or to the link. The
ground gives it to the rotor. On a vertical axis, that may be most of the load: an effect in
proportion to it then fits badly although it is there, and another name is found in its place.
"""

from dataclasses import replace

from lagrangian_ff.diagnosis.ground import Ground
from lagrangian_ff.diagnosis.search.candidates import HIDDEN_BY_DESIGN, Candidate, named
from lagrangian_ff.diagnosis.search.gain import scores
from lagrangian_ff.diagnosis.search.rivals import LEAST
from lagrangian_ff.effects import EFFECTS

SHARES = (0.25, 0.5, 0.75)
"""Of the rotor's torque that may be the link's instead."""


def hidden_by_guess(ground: Ground, candidate: Candidate) -> tuple[str, ...]:
    """Look-alikes in proportion to the load that fit as well as a candidate with another guess.

    Args:
        ground: without the candidate.
        candidate: a named one.
    """
    likes = [
        EFFECTS[name]
        for name in candidate.effect.look_alikes
        if name in EFFECTS and EFFECTS[name].follows_load and name not in HIDDEN_BY_DESIGN
    ]
    if candidate.effect.follows_load or not likes:
        return ()
    whole = ground.seen.whole or ground.seen
    weights = ground.system.weights.reshape(len(ground.index), ground.joints)
    rotors = ground.prior.rotors(whole, ground.seen, weights)
    mine = max(score.gain for score in scores(ground, [candidate]))
    found: dict[str, float] = {}
    for share in SHARES:
        heavier = replace(whole, load=whole.load + share * rotors)
        x = heavier.take(ground.index, ground.seen.window)
        others = named(x, ground.basis, [candidate.joint], {one.name: one for one in likes})
        for score in scores(replace(ground, seen=x), others):
            name = score.candidate.source.name
            found[name] = max(score.gain, found.get(name, score.gain))
    return tuple(name for name, gain in found.items() if gain > mine - LEAST)
