"""Exported URDF, MJCF and UR programs: bodies that can exist, read by other programs."""

from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from export_examples import Floats, curves, model_of, rms
from numpy.typing import NDArray

pytest.importorskip("pinocchio", reason="reading a URDF needs Pinocchio")

from lagrangian_ff.effects import EFFECTS
from lagrangian_ff.errors import ExportError, ModelError
from lagrangian_ff.export import Exported, Options, write
from lagrangian_ff.export.bodies import pseudo_inertia
from lagrangian_ff.identification import Model
from lagrangian_ff.identification.basis import Term
from lagrangian_ff.kernels import KERNELS, States
from lagrangian_ff.kernels.rigid import Robot, read_urdf

URDF = Path(__file__).parents[2] / "lagrangian_ff" / "arm" / "arm6.urdf"
ROTORS = np.array([1.2, 1.5, 0.4, 0.12, 0.05, 0.03])
LOAD = np.array([2.0, 0.1, 0.0, 0.2, 0.05, 0.0, 0.06, -0.01, 0.0, 0.03])  # on the last joint


@pytest.fixture(scope="module")
def robot() -> Robot:
    """The simulated arm."""
    return read_urdf(URDF)


def model_with(robot: Robot, inertial: Floats, rotors: Floats) -> Model:
    """A model of these bodies and rotors, with friction and offsets."""
    blind = model_of("none+fri", joints=6, names=robot.movable)
    kernel = robot.around(KERNELS["none"]).start(blind.centres)
    # Weights whose bodies are the wanted ones: solved for, as the kernel has a finite rank.
    kernel = replace(kernel, deviation=np.array([1.0]), armature=np.ones(6), bodies=np.ones(1))
    x = States.of(blind.data.q, blind.data.qd, blind.data.qdd)
    u = x.take(np.arange(0, len(x), 4))
    wanted = robot.tree.regressor(u) @ inertial.ravel() + rotors * u.qdd
    gram = kernel.cross(u, u)
    solved = np.linalg.lstsq(gram, wanted.ravel(), rcond=1e-13)[0]
    weights = np.asarray(solved.reshape(-1, 6), dtype=np.float64)
    scaling = replace(blind.prior.scaling, unit=np.ones(6))
    prior = replace(blind.prior, kernel=kernel, scaling=scaling)
    made = replace(blind, prior=prior, centres=u, weights=weights, data=replace(blind.data))
    tau = made.torque(made.inputs_of(made.data))
    return replace(made, data=replace(made.data, tau=tau))


@pytest.fixture(scope="module")
def model(robot: Robot) -> Model:
    """A model of the arm with a load on its last link, rotors, friction and offsets."""
    inertial = robot.tree.inertial.copy()
    inertial[-1] += LOAD
    return model_with(robot, inertial, ROTORS)


def inverse_dynamics(path: Path, x: States) -> Floats:
    """Torques of the bodies of a URDF by Pinocchio's recursive Newton-Euler algorithm."""
    import pinocchio

    built = pinocchio.buildModelFromUrdf(str(path))
    data = built.createData()
    rows = zip(x.q, x.qd, x.qdd, strict=True)
    return np.array([pinocchio.rnea(built, data, *row) for row in rows])


def states_of(model: Model, count: int = 40) -> tuple[States, NDArray[np.int64]]:
    some = np.linspace(0, len(model.data) - 1, count).astype(np.int64)
    data = model.data
    return States.of(data.q[some], data.qd[some], data.qdd[some]), some


def require_bodies_that_exist(found: Exported) -> None:
    """Every mass is positive, every inertia positive definite with the triangle inequality."""
    assert found.numbers is not None
    links = found.numbers["links_moved_by"]
    assert isinstance(links, dict)
    for link in links.values():
        moments = np.linalg.eigvalsh(np.array(link["inertia"]))
        assert link["mass"] > 0.0
        assert moments[0] > 0.0
        assert moments[0] + moments[1] > moments[2]


def joint_numbers(path: Path, tag: str, name: str) -> Floats:
    return np.array([float(one.attrib[name]) for one in ElementTree.parse(path).iter(tag)])


def test_a_urdf_has_the_torque_that_is_said_in_pinocchio(model: Model, tmp_path: Path) -> None:
    given, path = tmp_path / "given.urdf", tmp_path / "better.urdf"
    given.write_text(URDF.read_text().replace("<link", "<!-- mine --><link", 1))
    found = write(model, "urdf", path, Options(urdf=given))
    require_bodies_that_exist(found)
    x, some = states_of(model)
    damping, friction = (joint_numbers(path, "dynamics", n) for n in ("damping", "friction"))
    tau = inverse_dynamics(path, x) + damping * x.qd + friction * np.tanh(x.qd / 0.02)
    whole = model.torque(model.inputs_of(model.data))
    np.testing.assert_allclose(rms(tau - whole[some]), found.difference, rtol=0.5)
    without = rms(inverse_dynamics(URDF, x) - whole[some])
    assert (found.difference < 0.5 * without).all()
    assert {loss.what.split()[0] for loss in found.losses} == {"offset", "inertia"}
    assert "<!-- mine -->" in path.read_text()


def test_pybullet_reads_the_same_bodies(model: Model, tmp_path: Path) -> None:
    pybullet = pytest.importorskip("pybullet", reason="PyBullet is not installed")
    path = tmp_path / "better.urdf"
    write(model, "urdf", path, Options(urdf=URDF))
    x, _ = states_of(model, 20)
    client = pybullet.connect(pybullet.DIRECT)
    try:
        pybullet.setGravity(0.0, 0.0, -9.81, physicsClientId=client)
        flags = pybullet.URDF_USE_INERTIA_FROM_FILE
        body = pybullet.loadURDF(str(path), useFixedBase=True, flags=flags, physicsClientId=client)
        rows = zip(x.q.tolist(), x.qd.tolist(), x.qdd.tolist(), strict=True)
        tau = [
            pybullet.calculateInverseDynamics(body, *row, physicsClientId=client) for row in rows
        ]
    finally:
        pybullet.disconnect(client)
    expected = inverse_dynamics(path, x)
    np.testing.assert_allclose(tau, expected, atol=1e-4 * np.abs(expected).max())


def test_a_mujoco_model_has_bodies_rotors_and_friction(model: Model, tmp_path: Path) -> None:
    mujoco = pytest.importorskip("mujoco", reason="MuJoCo is not installed")
    path = tmp_path / "arm.xml"
    gained = replace(
        model,
        prior=replace(model.prior, basis=replace(model.basis, terms=(
            *model.basis.terms, Term(EFFECTS["torque_gain"], 1)))),
        coefficients=np.append(model.coefficients, 0.25),
    )  # fmt: skip
    found = write(gained, "mjcf", path, Options(urdf=URDF))
    assert found.numbers is not None
    assert found.numbers["torque_gain"] == pytest.approx([1.0, 0.8, 1.0, 1.0, 1.0, 1.0])
    write(model, "mjcf", path, Options(urdf=URDF))
    require_bodies_that_exist(found)
    built = mujoco.MjModel.from_xml_path(str(path))
    np.testing.assert_allclose(built.dof_armature, ROTORS, rtol=0.1)
    viscous = [c for t, c in zip(model.basis.terms, model.coefficients, strict=True)
               if t.effect.name == "viscous"]  # fmt: skip
    np.testing.assert_allclose(built.dof_damping, viscous, rtol=0.05)
    friction = built.dof_frictionloss.reshape(6).copy()
    built.dof_frictionloss[:] = 0.0  # soft constraints in MuJoCo, which follow no formula
    built.jnt_limited[:] = 0
    x, some = states_of(model)
    data = mujoco.MjData(built)
    tau = []
    for q, qd, qdd in zip(x.q, x.qd, x.qdd, strict=True):
        data.qpos[:], data.qvel[:], data.qacc[:] = q, qd, qdd
        mujoco.mj_inverse(built, data)
        tau.append(data.qfrc_inverse + friction * np.tanh(qd / 0.02))
    whole = model.torque(model.inputs_of(model.data))[some]
    offset = [c for t, c in zip(model.basis.terms, model.coefficients, strict=True)
              if t.effect.name == "offset"]  # fmt: skip
    near = rms(np.array(tau) + offset - whole) / rms(whole)
    assert (near < 0.03).all()


def test_a_ur_program_holds_the_payload_and_the_friction_that_is_left(
    robot: Robot, model: Model, tmp_path: Path
) -> None:
    path = tmp_path / "payload.script"
    worn = replace(model, coefficients=2.0 * model.coefficients)
    flange = [str(link.get("name")) for link in ElementTree.parse(URDF).iter("link")][-1]
    options = Options(urdf=URDF, earlier=worn, flange=flange)
    found = write(model, "ur", path, options)
    assert found.numbers is not None
    assert found.numbers["mass"] == pytest.approx(LOAD[0], rel=0.02)
    assert found.numbers["viscous_scale"] == pytest.approx([0.5] * 6)
    text = path.read_text()
    assert f"set_target_payload({found.numbers['mass']:.4f}, [" in text
    assert "coulomb_scale = [0.5000, 0.5000" in text
    assert not any("no friction scales" in note for note in found.notes)
    # The flange is where the last joint is, turned and moved by the fixed joint between them.
    alone = write(model, "ur", path, replace(options, earlier=None))
    assert "coulomb_scale" not in path.read_text()
    assert any("no friction scales" in note for note in alone.notes)
    with pytest.raises(ExportError, match="has no link hand: name"):
        write(model, "ur", path, replace(options, flange="hand"))


def test_what_a_curve_costs_is_named_where_no_curve_fits(model: Model, tmp_path: Path) -> None:
    curve = curves()[0]
    bent = replace(
        model,
        prior=replace(model.prior, basis=replace(model.basis, terms=(*model.basis.terms, curve))),
        coefficients=np.append(model.coefficients, [1.0, -2.0, 0.5, 3.0]),
    )
    parts = bent.basis.torque(bent.inputs_of(bent.data), bent.coefficients)
    flange = [str(link.get("name")) for link in ElementTree.parse(URDF).iter("link")][-1]
    for name in ("urdf", "mjcf", "ur"):
        found = write(bent, name, tmp_path / name, Options(urdf=URDF, flange=flange))
        (lost,) = (loss for loss in found.losses if loss.what == "curve_velocity")
        np.testing.assert_allclose(lost.rms, rms(parts["curve_velocity"]))
        assert lost.rms[0] > 0.1
        assert found.difference[0] > 0.1


def test_what_cannot_be_described_is_refused(model: Model, tmp_path: Path) -> None:
    for name in ("urdf", "mjcf", "ur"):
        with pytest.raises(ExportError, match="give --urdf"):
            write(model, name, tmp_path / "arm")
    with pytest.raises(ModelError, match="are not those of the URDF"):
        write(model_of(names="abc"), "urdf", tmp_path / "arm", Options(urdf=URDF))
    weightless = replace(
        model, data=replace(model.data, conditioning={"effort": "without-gravity"})
    )
    with pytest.raises(ExportError, match="no payload has weight"):
        write(weightless, "ur", tmp_path / "arm", Options(urdf=URDF))


def test_pseudo_inertias_of_bodies_that_exist_are_positive(robot: Robot) -> None:
    assert (np.linalg.eigvalsh(pseudo_inertia(robot.tree.inertial)) > 0.0).all()
    impossible = robot.tree.inertial.copy()
    impossible[:, 9] *= 50.0  # one moment above the sum of the other two
    assert (np.linalg.eigvalsh(pseudo_inertia(impossible))[:, 0] < 0.0).any()
