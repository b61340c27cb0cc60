from pathlib import Path

import numpy as np
import pytest

from lagrangian_ff.errors import RecordingError
from lagrangian_ff.recording import load


@pytest.mark.parametrize("byte", [0, 1, *b"'(9"])
def test_a_damaged_archive_is_never_a_crash(tmp_path: Path, byte: int) -> None:
    path = tmp_path / "arm.npz"
    # Long enough that the header is read before the archive's checksum can tell.
    t = np.arange(0.0, 20.0, 0.01)
    arm = {"position": np.sin(t)[:, None], "velocity": np.cos(t)[:, None], "effort": t[:, None]}
    np.savez(path, time=t, **arm)
    whole = path.read_bytes()
    first = whole.index(b"\x93NUMPY")
    refused = 0
    for place in range(first, first + 128):
        path.write_bytes(whole[:place] + bytes([byte]) + whole[place + 1 :])
        try:
            load(path)
        except RecordingError as error:
            refused += 1
            assert str(path) in str(error)  # noqa: PT017
    assert refused > 50
