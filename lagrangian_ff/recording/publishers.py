"""Which joints come in the same messages."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.recording.recording import Recording

Ints = NDArray[np.int64]


@dataclass(frozen=True)
class Publisher:
    """One of the nodes that took turns on a topic, as far as the messages tell.

    Attributes:
        rows: (K,) the samples it published.
        joints: (J,) the columns it tells of.
    """

    rows: Ints
    joints: Ints


def publishers(recording: Recording) -> list[Publisher]:
    """Joints that are told of together in most messages share a publisher."""
    told = np.isfinite(recording.position) | np.isfinite(recording.effort)
    left = list(range(len(recording.joints)))
    found = []
    while left:
        first = told[:, left[0]]
        enough = np.count_nonzero(first) / 2
        common = [j for j in left if np.count_nonzero(told[:, j] & first) > enough] or left[:1]
        left = [joint for joint in left if joint not in common]
        joints = np.array(common, dtype=np.int64)
        found.append(Publisher(np.flatnonzero(told[:, joints].any(axis=1)), joints))
    return found
