"""What was measured: recordings, what was found in them, and the motion made of them."""

from lagrangian_ff.recording.bag_writer import BagWriter, write_bag
from lagrangian_ff.recording.conditioning import Conditioning, condition
from lagrangian_ff.recording.inspection import Inspection, inspect
from lagrangian_ff.recording.load import load
from lagrangian_ff.recording.motion import Motion, concatenate
from lagrangian_ff.recording.recording import Recording
from lagrangian_ff.recording.tables import write_csv, write_npz

__all__ = [
    "BagWriter",
    "Conditioning",
    "Inspection",
    "Motion",
    "Recording",
    "concatenate",
    "condition",
    "inspect",
    "load",
    "write_bag",
    "write_csv",
    "write_npz",
]
