"""The format `onnx`: a graph of the torque for ONNX runtimes, in numbers of 64 bits."""

from pathlib import Path

from lagrangian_ff.errors import ExportError
from lagrangian_ff.export.onnx_graph import Graph, torque
from lagrangian_ff.export.portable import portable
from lagrangian_ff.export.result import Exported, Options, exported, settled_losses, settled_torque
from lagrangian_ff.identification import Model

NAME = "onnx"
SUMMARY = "a graph for ONNX runtimes: q, qd, qdd in, tau out, any number of states at once"
SUFFIX = ".onnx"
URDF = False
OPSET, IR = 18, 9
"""Versions that runtimes of 2023 and later read."""


def write(model: Model, path: Path, options: Options) -> Exported:
    """Write an ONNX file; see `Format`."""
    try:
        import onnx
    except ImportError as error:
        raise ExportError(
            "writing ONNX needs the package onnx, which is not installed; it is the extra 'onnx' "
            "of lagrangian_ff: pip install onnx"
        ) from error
    held = portable(model, settled=options.settled)
    graph, joints = Graph(), len(held.joints)
    found = torque(graph, held, "q", "qd", "qdd")
    graph.nodes.append(onnx.helper.make_node("Identity", [found], ["tau"]))
    values = [
        onnx.helper.make_tensor_value_info(name, onnx.TensorProto.DOUBLE, ["states", joints])
        for name in ("q", "qd", "qdd", "tau")
    ]
    made = onnx.helper.make_model(
        onnx.helper.make_graph(graph.nodes, "torque", values[:3], values[3:], graph.constants),
        opset_imports=[onnx.helper.make_opsetid("", OPSET)],
        ir_version=IR,
        producer_name="lagrangian_ff",
        doc_string=f"{held.source} of {', '.join(held.joints)}",
    )
    onnx.checker.check_model(made)
    path.write_bytes(made.SerializeToString())
    losses = settled_losses(model, held.settled)
    return exported(model, NAME, (".",), settled_torque(model), losses)
