"""The rigid-body part of a model as numbers and a formula that need no code of ours.

Each form is a record of numbers: JSON holds its fields, `c/<kind>.c` computes its torque. Torques
are in the model's units: joint n counts `unit[n]` N·m as one.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import ClassVar, TypeVar

import numpy as np

from lagrangian_ff.arrays import Floats, Ints
from lagrangian_ff.errors import ExportError
from lagrangian_ff.kernels import Kernel, States
from lagrangian_ff.kernels.base import of_joint
from lagrangian_ff.kernels.baselines import Motor, Nothing, Pol, Rbf, Rbfs
from lagrangian_ff.kernels.constrained import Closed
from lagrangian_ff.kernels.lagrangian import Srbf, Srbfs, Svrbf, Svrbfs, Vrbf, Vrbfs
from lagrangian_ff.kernels.rigid.known import Known
from lagrangian_ff.kernels.structured.base import Structured
from lagrangian_ff.kernels.structured.chain import LONG, SHORT, Chain, Polynomial

Self = TypeVar("Self", bound="Form")


@dataclass(frozen=True)
class Form:
    """A torque that is a function of the state.

    Attributes:
        linear: the fields that the torque is in proportion to.
    """

    kind: ClassVar[str]
    linear: ClassVar[tuple[str, ...]]

    def scaled(self: Self, factor: float) -> Self:
        """Return the torque times a factor."""
        return replace(self, **{name: factor * getattr(self, name) for name in self.linear})


@dataclass(frozen=True)
class Trigonometric(Form):
    """Rigid links as trigonometric polynomials: mass matrix, potential energy and rotors.

    With j <= k, M_jk is of first degree in cosine and sine of the joints j+1 .. k and of second
    degree in those beyond. `mass` holds for each k an array of shape (5,) * (N - 1 - k) + (R_k,),
    the last joint first, R_k = 3 R_{k-1} + 1, R_0 = 1; all are flat, one behind the other. The 5
    are factors of 1, cos q, sin q, cos 2q, sin 2q. Of R_k the last is of M_kk, those before are
    the 3 of 1, cos q_k, sin q_k times R_{k-1}, built in the same way: the last of these is of
    M_{k-1,k}. `potential` is V's, (3,) * N, the last joint first; L is qd' M qd / 2 - V.
    """

    mass: Floats
    potential: Floats
    rotor: Floats

    kind = "trigonometric"
    linear = ("mass", "potential", "rotor")

    @classmethod
    def of(cls, learned: Polynomial, joints: int) -> "Trigonometric":
        """Return the form of a learned chain of N joints, its numbers in the order above."""
        flat, blocks = learned.mass, []
        places = np.zeros(1, dtype=np.int64)
        for k in range(joints):
            if k:
                inner = [SHORT * places + f for f in range(SHORT)]
                places = np.concatenate([*inner, [SHORT * len(places)]])
            size = len(places), *[LONG] * (joints - 1 - k)
            block = flat[: int(np.prod(size))].reshape(size)[places]
            flat = flat[block.size :]
            blocks.append(block.transpose().ravel())
        height = -learned.potential.reshape([SHORT] * joints).transpose().ravel()
        return cls(np.concatenate(blocks), height, learned.rotor)


@dataclass(frozen=True)
class LagrangianRbf(Form):
    """One Lagrangian, a sum of the kernel (36) pushed through (22), over C centres.

    Attributes:
        angles: whether positions count by cosine and sine, (39), or as they are, (38).
        alpha, w: (N,) 1/σ and c²/σ.
        q, qd, qdd, weights: (C, N).
    """

    angles: bool
    alpha: Floats
    w: Floats
    q: Floats
    qd: Floats
    qdd: Floats
    weights: Floats

    kind = "lagrangian_rbf"
    linear = ("weights",)


@dataclass(frozen=True)
class JointRbf(LagrangianRbf):
    """A Lagrangian for each joint, (30), (35): the diagonal of `lagrangian_rbf`.

    Attributes:
        alpha, w: (N,) 1/σ and c²/σ of the kernel of each joint.
    """

    kind = "joint_rbf"


@dataclass(frozen=True)
class StateRbf(Form):
    """No structure, (52), (53): joint n's sum over C centres of exp(-|x - u|² / 2σ_n).

    Attributes:
        angles: whether x has cos q and sin q, or q.
        velocity_scale, acceleration_scale: (N,) factors of qd and qdd in x, for each joint's sum.
        half: (N,) 1 / 2σ.
        q, qd, qdd, weights: (C, N).
    """

    angles: bool
    velocity_scale: Floats
    acceleration_scale: Floats
    half: Floats
    q: Floats
    qd: Floats
    qdd: Floats
    weights: Floats

    kind = "state_rbf"
    linear = ("weights",)


@dataclass(frozen=True)
class PolSum(Form):
    """The benchmark `pol`: (1 + qdd·qdd' + (qd·qd')²) Π ((1 + cos(q - q')) / 2)², over centres.

    Attributes:
        velocity_scale, acceleration_scale: (N,) factors of qd and qdd, for each joint's sum.
        q, qd, qdd, weights: (C, N).
    """

    velocity_scale: Floats
    acceleration_scale: Floats
    q: Floats
    qd: Floats
    qdd: Floats
    weights: Floats

    kind = "pol"
    linear = ("weights",)


@dataclass(frozen=True)
class Motors(Form):
    """Each joint a motor: inertia qdd + viscous qd, (54)."""

    inertia: Floats
    viscous: Floats

    kind = "motors"
    linear = ("inertia", "viscous")


@dataclass(frozen=True)
class Mechanical(Form):
    """Kinetic and potential energy with factors of the angles, summed over C centres.

    The kernel is that of `loops/serial.c` (serial) or `product.c`, and of `structured.c`.

    Attributes:
        serial: whether each link's energy depends on the joints before it alone.
        form: (N,) 0 (1 + ω cos d) / (1 + ω), 1 exp(-ω (1 - cos d)), 2 exp(-ω d² / 2).
        inertia, link, potential, wave, swing, rotor: (N,) Λ, κ, λ, ω, ω, ρ.
        q, qd, qdd, weights: (C, N).
    """

    serial: bool
    form: Ints
    inertia: Floats
    link: Floats
    potential: Floats
    wave: Floats
    swing: Floats
    rotor: Floats
    q: Floats
    qd: Floats
    qdd: Floats
    weights: Floats

    kind = "mechanical"
    linear = ("weights",)


@dataclass(frozen=True)
class Bodies(Form):
    """Rigid bodies on joints, by Newton and Euler, and rotors; see `kernels/rigid/tree.py`.

    Attributes:
        parent, driver: (B,) the body that carries each, −1 the base; the coordinate that moves it.
        rotation, offset, axis: (B, 3, 3), (B, 3), (B, 3) of its joint, in the parent's frame.
        sliding, ratio, shift: (B,) 1 where it slides; joint position = ratio q + shift.
        inertial: (B, 10) m, m c, Ixx, Ixy, Iyy, Ixz, Iyz, Izz about the origin of its frame.
        gravity: (3,) m/s².  rotor: (N,) times qdd.
    """

    parent: Ints
    driver: Ints
    rotation: Floats
    offset: Floats
    axis: Floats
    sliding: Floats
    ratio: Floats
    shift: Floats
    inertial: Floats
    gravity: Floats
    rotor: Floats

    kind = "bodies"
    linear = ("inertial", "rotor")


def forms_of(kernel: Kernel, u: States, a: Floats) -> tuple[Form, ...]:
    """Return the forms whose sum is the torque Σ_j K(·, u_j) a_j.

    Args:
        kernel: of the model.  u: (C, N) states.  a: (C, N) weights.

    Raises:
        ExportError: there is none for this kernel; says why.
    """
    for kinds, make in _FORMS.items():
        if isinstance(kernel, kinds):
            return make(kernel, u, a)
    raise ExportError(
        f"the kernel {kernel.name} has no form outside this package; export a model of chain, or "
        "of another kernel that `lagrangian_ff identify --help` lists"
    )


def _refused(kernel: Kernel, u: States, a: Floats) -> tuple[Form, ...]:
    raise ExportError(
        "the model is of a mechanism with closed loops, whose geometry is Python code of yours: "
        "export a model of the tree of its joints instead"
    )


def _known(kernel: Known, u: States, a: Floats) -> tuple[Form, ...]:
    tree = kernel.of.tree
    bodies = Bodies(
        parent=tree.parent, driver=tree.driver, rotation=tree.rotation, offset=tree.offset,
        axis=tree.axis, sliding=tree.sliding, ratio=tree.ratio, shift=tree.shift,
        inertial=kernel.inertial(u, a), gravity=tree.gravity, rotor=kernel.rotors(u, a),
    )  # fmt: skip
    inner = forms_of(kernel.kernel, u, a)
    return (bodies, *(one.scaled(float(kernel.correction[0])) for one in inner))


def _structured(kernel: Structured, u: States, a: Floats) -> tuple[Form, ...]:
    if isinstance(kernel, Chain):
        learned = kernel.learned(u, a)
        if isinstance(learned, Polynomial):
            return (Trigonometric.of(learned, u.joints),)
    _, serial, form, numbers = kernel.numbers()
    inertia, link, potential, wave, swing, rotor = numbers
    return (
        Mechanical(
            bool(serial), form, inertia, link, potential, wave, swing, rotor, *_centres(u, a)
        ),
    )


def _coupled(kernel: "Vrbf | Vrbfs", u: States, a: Floats) -> tuple[Form, ...]:
    _, angles, alpha, w = kernel.numbers(u.joints)
    return (LagrangianRbf(bool(angles), alpha, w, *_centres(u, a)),)


def _apart(kernel: "Srbf | Srbfs", u: States, a: Floats) -> tuple[Form, ...]:
    alpha = np.array([kernel.numbers(u.joints, n)[2][0] for n in range(u.joints)])
    w = np.array([kernel.numbers(u.joints, n)[3][0] for n in range(u.joints)])
    return (JointRbf(kernel.angles, alpha, w, *_centres(u, a)),)


def _rbf(kernel: Rbf, u: States, a: Floats) -> tuple[Form, ...]:
    half = 0.5 / _spread(kernel.sigma, u.joints)
    return (StateRbf(isinstance(kernel, Rbfs), *_scales(kernel, u), half, *_centres(u, a)),)


def _pol(kernel: Pol, u: States, a: Floats) -> tuple[Form, ...]:
    return (PolSum(*_scales(kernel, u), *_centres(u, a)),)


def _motor(kernel: Motor, u: States, a: Floats) -> tuple[Form, ...]:
    velocity, acceleration = _scales(kernel, u)
    return (
        Motors(acceleration**2 * np.sum(u.qdd * a, axis=0), velocity**2 * np.sum(u.qd * a, axis=0)),
    )


def _scales(kernel: "Rbf | Pol | Motor", u: States) -> tuple[Floats, Floats]:
    """Return (N,) the factors of velocity and acceleration."""
    v, a = kernel.velocity_scale, kernel.acceleration_scale
    return _spread(v, u.joints), _spread(a, u.joints)


def _spread(values: Floats, joints: int) -> Floats:
    """Return (N,) the values of each joint of a hyperparameter."""
    return np.array([of_joint(values, n) for n in range(joints)])


def _centres(u: States, a: Floats) -> tuple[Floats, Floats, Floats, Floats]:
    return u.q, u.qd, u.qdd, a


_Make = Callable[..., tuple[Form, ...]]
_FORMS: Mapping[tuple[type[Kernel], ...], _Make] = {
    (Closed,): _refused,
    (Known,): _known,
    (Structured,): _structured,
    (Vrbf, Vrbfs): _coupled,
    (Srbf, Srbfs, Svrbf, Svrbfs): _apart,
    (Rbf,): _rbf,
    (Pol,): _pol,
    (Motor,): _motor,
    (Nothing,): lambda *_: (),
}
"""How each kernel becomes forms; a new kernel is a line here."""
