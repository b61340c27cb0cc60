"""`info`: the content of a recording or a model file."""

import zipfile
from argparse import ArgumentParser, Namespace
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from lagrangian_ff.cli.common import options
from lagrangian_ff.cli.common.console import Console, progress_bar
from lagrangian_ff.cli.common.outputs import check_outputs, check_sources, write_record
from lagrangian_ff.cli.common.sources import read, say_inspection
from lagrangian_ff.cli.text.model import range_table, say_identified
from lagrangian_ff.errors import RecordingError, UserError

if TYPE_CHECKING:
    from lagrangian_ff.recording import Motion

NAME = "info"
SUMMARY = "show what a recording or a model file holds"
USAGE = "SOURCE|MODEL [options]"
DESCRIPTION = """\
Shows what a file holds. Of a recording: joints, rate, jitter, gaps, missing or clipped values,
and whether a model can be identified from it; with --report a page with the spectra that its
bandwidth was chosen from, and with --observable the least size at which diagnose would see each
effect on each joint, and the motion to do for the others. Of a model: its joints, error, effects as
equations, hyperparameters, and the motion it was identified on."""
EPILOG = """\
examples:
  lagrangian_ff info bag
  lagrangian_ff info bag --report bag.html
  lagrangian_ff info bag --observable
  lagrangian_ff info model.npz --json -"""


def add_arguments(parser: ArgumentParser) -> None:
    what = f"{options.SOURCE_HELP}; or a model file of identify"
    parser.add_argument("file", type=Path, metavar="SOURCE|MODEL", help=what)
    options.add_reading(parser)
    options.add_report(parser)
    options.add_rows(parser, [(
        "--observable", bool, "", "show which effects the motion could show, before a model is "
        "learned; takes some seconds",
    )])  # fmt: skip
    options.add_common(parser)


def run(arguments: Namespace) -> int:
    console = Console(arguments.json)
    path = arguments.file
    check_sources([path])
    check_outputs(arguments, [path])
    options.load_own_effects(arguments, console)
    if is_model(path):
        if arguments.report is not None:
            raise UserError("--report: info makes a page of a recording, not of a model")
        if arguments.observable:
            raise UserError("--observable: info looks at a recording, not at a model")
        record = _model(path, console)
    else:
        record = _recording(arguments, console)
    write_record(arguments.json, record)
    return 0


def is_model(path: Path) -> bool:
    """Return whether a file is a model rather than a recording: both end in .npz."""
    if path.suffix != ".npz" or not zipfile.is_zipfile(path):
        return False
    with zipfile.ZipFile(path) as archive:
        return "header.npy" in archive.namelist()


def _model(path: Path, console: Console) -> dict[str, object]:
    from lagrangian_ff.identification import Model

    model = Model.load(path)
    console.say(f"{path}: model {model.name} of {', '.join(model.joints)}")
    if model.identified.sources:
        console.say(f"identified from {', '.join(model.identified.sources)}")
    console.say()
    say_identified(model.identified, console)
    console.say(["", "the motion it was identified on"])
    console.say(range_table(model.range, model.joints))
    return {"kind": "model", "joint_names": list(model.joints), **model.record}


def _recording(arguments: Namespace, console: Console) -> dict[str, object]:
    from lagrangian_ff.recording import condition, converted, inspect, measured_bandwidth

    try:
        recording = read(arguments.file, arguments.topic)
    except RecordingError as error:
        if arguments.file.suffix == ".npz":
            raise RecordingError(f"{error}; nor is it a model file of identify") from error
        raise
    conditioning = options.conditioning_of(arguments)
    inspection = inspect(converted(recording, conditioning.units))
    say_inspection(inspection, console)
    console.say()
    try:
        motion = condition(recording, conditioning)
    except RecordingError as error:
        for doubt in inspection.doubts:
            console.note(doubt.text(), "  ")
        console.say(f"cannot be identified from as it is: {error}")
        return {"kind": "recording", **inspection.record(), "usable": False, "reason": str(error)}
    for note in motion.notes:
        console.note(note, "  ")
    console.say(f"can be identified from: {len(motion)} samples of {len(motion.joints)} joints")
    if arguments.report is not None:
        from lagrangian_ff.report.pages import Read, recording_page

        bandwidth = measured_bandwidth([recording], conditioning)
        if conditioning.bandwidth is not None:
            given = f"bandwidth {conditioning.bandwidth:g} Hz, as given; auto: {bandwidth.reason}"
            bandwidth = replace(bandwidth, hertz=conditioning.bandwidth, reason=given)
        page = recording_page(arguments.report, Read(inspection, bandwidth, motion.notes))
        console.say(f"page: {page}")
    used = motion.conditioning["bandwidth"]
    more = {"observable": _observable(motion, console)} if arguments.observable else {}
    return {
        "kind": "recording", **inspection.record(), "bandwidth": used, "usable": True, "reason": "",
        **more,
    }  # fmt: skip


def _observable(motion: "Motion", console: Console) -> dict[str, object]:
    """Say which effects a motion could show, and return it for JSON."""
    from lagrangian_ff.cli.text.diagnose import say_observability
    from lagrangian_ff.diagnosis.observable import observability
    from lagrangian_ff.identification import joint_order
    from lagrangian_ff.identification.settings import usual_model
    from lagrangian_ff.progress import part

    with progress_bar("what it could show") as progress:
        order = joint_order([motion], usual_model(motion.effort), None, part(progress, 0.0, 0.4))
        found = observability(motion.select(order.joints), progress=part(progress, 0.4, 1.0))
    say_observability(found, console)
    return found.record()
