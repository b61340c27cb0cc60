"""The picture of the arm."""

from pathlib import Path

import numpy as np
from matplotlib import image

from lagrangian_ff.arm import HOME, picture
from lagrangian_ff.arm.drawing import BACKGROUND, mesh


def drawn(path: Path, **options: object) -> np.ndarray:
    picture(path, size=120, **options)  # type: ignore[arg-type]
    return np.asarray(image.imread(path))[:, :, :3]


def test_the_picture_shows_an_arm_on_a_plain_background(tmp_path: Path) -> None:
    pixels = drawn(tmp_path / "arm.png")
    assert pixels.shape == (120, 120, 3)
    background = np.all(np.abs(pixels - BACKGROUND) < 0.01, axis=2)
    assert background[:10].all()
    assert 0.3 < background.mean() < 0.9
    # The amber rings are the only saturated orange.
    amber = (pixels[:, :, 0] - pixels[:, :, 2]) > 0.4
    assert amber.any()


def test_pose_and_loads_change_the_picture(tmp_path: Path) -> None:
    plain = drawn(tmp_path / "a.png")
    loaded = drawn(tmp_path / "b.png", loads={"joint_1": 2.5})
    moved = drawn(tmp_path / "c.png", q=HOME)
    assert np.abs(plain - loaded).max() > 0.1
    assert np.abs(plain - moved).max() > 0.1


def test_meshes_are_closed_and_face_outwards() -> None:
    import pybullet

    for kind, size, volume in (
        (pybullet.GEOM_CYLINDER, (0.2, 0.05), np.pi * 0.05**2 * 0.2),
        (pybullet.GEOM_SPHERE, (0.1,), 4 / 3 * np.pi * 0.1**3),
        (pybullet.GEOM_BOX, (0.1, 0.2, 0.3), 0.006),
    ):
        vertices, normals, triangles = mesh(kind, size)
        a, b, c = (vertices[triangles[:, k]] for k in range(3))
        # Gauss: a closed surface that faces outwards encloses its volume, with the right sign.
        assert np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6 == np.clip(
            np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6, 0.97 * volume, volume
        )
        np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0, atol=1e-9)
