"""PyBullet's dynamics of the arm against a second derivation, from the URDF and energies alone."""

from collections.abc import Iterator
from xml.etree import ElementTree

import numpy as np
import pytest
from arm_examples import bias, mass_matrix, potential_energy
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from lagrangian_ff.arm import JOINTS, PAPER_LOADS, Load, limits, robot_description
from lagrangian_ff.arm.body import GRAVITY, Body

Floats = NDArray[np.float64]


class Chain:
    """Mass matrix and potential energy of a URDF, by Jacobians of the links' centres of mass."""

    def __init__(self, urdf: str) -> None:
        root = ElementTree.fromstring(urdf)
        self.links = {link.attrib["name"]: link for link in root.iter("link")}
        self.joints = list(root.iter("joint"))

    @staticmethod
    def vector(element: ElementTree.Element | None, key: str) -> Floats:
        text = "0 0 0" if element is None else element.get(key, "0 0 0")
        return np.array([float(x) for x in text.split()])

    def mass_and_potential(self, q: Floats) -> tuple[Floats, float]:
        frames = {"base_link": (np.eye(3), np.zeros(3))}
        axes: dict[str, list[tuple[int, Floats, Floats]]] = {"base_link": []}
        for joint in self.joints:
            parent = joint.find("parent").get("link")  # type: ignore[union-attr]
            child = joint.find("child").get("link")  # type: ignore[union-attr]
            assert parent is not None
            assert child is not None
            turn, place = frames[parent]
            place = place + turn @ self.vector(joint.find("origin"), "xyz")
            tilt = self.vector(joint.find("origin"), "rpy")
            turn = turn @ Rotation.from_euler("xyz", tilt).as_matrix()
            axes[child] = list(axes[parent])
            if joint.get("type") == "revolute":
                n = JOINTS.index(joint.attrib["name"])
                axis = self.vector(joint.find("axis"), "xyz")
                axes[child].append((n, turn @ axis, place))
                turn = turn @ Rotation.from_rotvec(q[n] * axis).as_matrix()
            frames[child] = (turn, place)
        matrix, potential = np.zeros((6, 6)), 0.0
        for name, (turn, place) in frames.items():
            if name == "base_link":
                continue
            link = self.links[name]
            mass = float(link.find("inertial/mass").attrib["value"])  # type: ignore[union-attr]
            entry = link.find("inertial/inertia").attrib  # type: ignore[union-attr]
            i = {key: float(value) for key, value in entry.items()}
            tensor = np.array(
                [
                    [i["ixx"], i["ixy"], i["ixz"]],
                    [i["ixy"], i["iyy"], i["iyz"]],
                    [i["ixz"], i["iyz"], i["izz"]],
                ]
            )
            centre = place + turn @ self.vector(link.find("inertial/origin"), "xyz")
            linear, angular = np.zeros((3, 6)), np.zeros((3, 6))
            for n, axis, origin in axes[name]:
                linear[:, n] = np.cross(axis, centre - origin)
                angular[:, n] = axis
            matrix += mass * linear.T @ linear
            matrix += angular.T @ turn @ tensor @ turn.T @ angular
            potential += mass * GRAVITY * centre[2]
        return matrix, potential

    def inverse_dynamics(self, q: Floats, qd: Floats, qdd: Floats) -> Floats:
        """Lagrange's equations, derivatives over q by central differences."""
        h = 1e-5
        slopes = np.empty((6, 6, 6))
        gravity = np.empty(6)
        for k in range(6):
            step = h * np.eye(6)[k]
            after, before = self.mass_and_potential(q + step), self.mass_and_potential(q - step)
            slopes[k] = (after[0] - before[0]) / (2 * h)
            gravity[k] = (after[1] - before[1]) / (2 * h)
        mass = self.mass_and_potential(q)[0]
        rate = np.einsum("kij,k->ij", slopes, qd)
        return mass @ qdd + rate @ qd - 0.5 * np.einsum("kij,i,j->k", slopes, qd, qd) + gravity


@pytest.fixture(scope="module")
def body() -> Iterator[Body]:
    with Body() as it:
        yield it


def states(count: int, seed: int = 0) -> tuple[Floats, Floats, Floats]:
    random = np.random.default_rng(seed)
    low, high, velocity, _ = limits()
    return (
        random.uniform(low, high, (count, 6)),
        random.uniform(-velocity, velocity, (count, 6)),
        random.normal(0.0, 10.0, (count, 6)),
    )


@pytest.mark.parametrize("loads", [None, PAPER_LOADS, {"link_5": Load(0.7, (0.1, 0.05, 0.02))}])
def test_inverse_dynamics_follow_from_the_lagrangian_of_the_urdf(loads: dict | None) -> None:
    chain = Chain(robot_description(loads))
    q, qd, qdd = states(8)
    with Body(loads) as it:
        torque = it.inverse_dynamics(q, qd, qdd)
    expected = np.array([chain.inverse_dynamics(*row) for row in zip(q, qd, qdd, strict=True)])
    np.testing.assert_allclose(torque, expected, rtol=1e-6, atol=1e-6)


def test_mass_matrix_follows_from_the_jacobians_of_the_urdf(body: Body) -> None:
    chain = Chain(robot_description())
    for q in states(10, seed=1)[0]:
        np.testing.assert_allclose(
            mass_matrix(body, q), chain.mass_and_potential(q)[0], rtol=1e-8, atol=1e-9
        )


def test_a_load_adds_its_own_inertia_about_the_first_axis(body: Body) -> None:
    load = Load(2.5, (-0.2, 0.1, 0.3))
    with Body({"joint_1": load}) as loaded:
        for q in states(3)[0]:
            more = mass_matrix(loaded, q) - mass_matrix(body, q)
            expected = 2.5 * (0.2**2 + 0.1**2) + 0.4 * 2.5 * load.radius**2
            assert more[0, 0] == pytest.approx(expected, rel=1e-6)
            more[0, 0] = 0.0
            np.testing.assert_allclose(more, 0.0, atol=1e-9)


def test_a_load_weighs_at_its_lever(body: Body) -> None:
    with Body({"link_2": Load(1.0, (0.0, 0.0, 0.36))}) as loaded:
        for angle in (-1.0, 0.3, 1.5):
            q = np.array([0.4, angle, 0.2, 0.0, 0.1, 0.0])
            more = bias(loaded, q, np.zeros(6)) - bias(body, q, np.zeros(6))
            # The arm leans forward with growing angle and would fall on: the motor holds it back.
            expected = np.array([0.0, -GRAVITY * 0.36 * np.sin(angle), 0.0, 0.0, 0.0, 0.0])
            np.testing.assert_allclose(more, expected, atol=1e-9)


joint_angles = st.lists(st.floats(-2.0, 2.0), min_size=6, max_size=6).map(np.array)


@settings(max_examples=30, deadline=None)
@given(q=joint_angles)
def test_mass_matrix_is_symmetric_and_positive(body: Body, q: Floats) -> None:
    mass = mass_matrix(body, q)
    np.testing.assert_allclose(mass, mass.T, atol=1e-12)
    assert np.linalg.eigvalsh(mass)[0] > 1e-4


def test_gravity_is_the_slope_of_the_potential_energy(body: Body) -> None:
    h = 1e-5
    for q in states(5, seed=2)[0]:
        slope = np.empty(6)
        for n in range(6):
            energies = []
            for sign in (1.0, -1.0):
                body.set_state(q + sign * h * np.eye(6)[n], np.zeros(6))
                energies.append(potential_energy(body))
            slope[n] = (energies[0] - energies[1]) / (2 * h)
        np.testing.assert_allclose(bias(body, q, np.zeros(6)), slope, atol=1e-6)


def test_inverse_dynamics_are_linear_in_acceleration(body: Body) -> None:
    q, qd, qdd = states(4, seed=3)
    torque = body.inverse_dynamics(q, qd, qdd)
    for row in range(4):
        expected = bias(body, q[row], qd[row]) + mass_matrix(body, q[row]) @ qdd[row]
        np.testing.assert_allclose(torque[row], expected, rtol=1e-9, atol=1e-9)


def test_closing_twice_ends_no_other_world() -> None:
    first = Body()
    client = first.client
    first.close()
    with Body() as second:
        assert second.client == client, "the number is free again"
        first.close()
        assert (np.linalg.eigvalsh(mass_matrix(second, np.zeros(6))) > 0.0).all()
