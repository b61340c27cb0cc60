"""`info`: the content of a recording or a model file."""

import zipfile
from argparse import ArgumentParser, Namespace
from dataclasses import replace
from pathlib import Path

from lagrangian_ff.cli.common import options
from lagrangian_ff.cli.common.console import Console
from lagrangian_ff.cli.common.outputs import check_outputs, check_sources, write_record
from lagrangian_ff.cli.common.sources import read, say_inspection
from lagrangian_ff.cli.text.model import range_table, say_identified
from lagrangian_ff.errors import RecordingError, UserError

NAME = "info"
SUMMARY = "show what a recording or a model file holds"
USAGE = "SOURCE|MODEL [options]"
DESCRIPTION = """\
Shows what a file holds. Of a recording: joints, rate, jitter, gaps, missing or clipped values,
and whether a model can be identified from it; with --report a page with the spectra that its
bandwidth was chosen from. Of a model: its joints, error, effects as
equations, hyperparameters, and the motion it was identified on."""
EPILOG = """\
examples:
  lagrangian_ff info bag
  lagrangian_ff info bag --report bag.html
  lagrangian_ff info model.npz --json -"""


def add_arguments(parser: ArgumentParser) -> None:
    what = f"{options.SOURCE_HELP}; or a model file of identify"
    parser.add_argument("file", type=Path, metavar="SOURCE|MODEL", help=what)
    options.add_reading(parser)
    options.add_report(parser)
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
    return {
        "kind": "recording", **inspection.record(), "bandwidth": used, "usable": True, "reason": "",
    }  # fmt: skip
