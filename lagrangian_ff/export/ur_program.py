"""The format `ur`: payload and friction scales of a Universal Robots program.

The controller has its own model of the arm, which no program can replace. It can be told what hangs
on its flange, and which part of its own friction to make up for. Both are differences: from the
bodies of the URDF, and from an earlier model of the same arm.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np

from lagrangian_ff.arrays import Floats
from lagrangian_ff.errors import ExportError, ModelError
from lagrangian_ff.export.bodies import FRICTION, Fit, fit
from lagrangian_ff.export.result import Exported, Options, exported
from lagrangian_ff.export.urdf_file import Inertial, read
from lagrangian_ff.identification import Model
from lagrangian_ff.kernels.rigid import Robot

NAME = "ur"
SUMMARY = "URScript: the payload at the flange, and friction scales beside an earlier model"
SUFFIX = ".script"
URDF = True
START = np.array([1.0, 0, 0, 0, 0.01, 0, 0.01, 0, 0, 0.01])
"""kg, kg·m, kg·m² of a load to begin with, which the motion may change as it likes."""
DEVIATION = 1.0
TORQUES = (
    "masses come out in kg only where the efforts are N·m: those of a UR are currents times a "
    "constant unless `calibrate` has found the scale"
)
BESIDE = (
    "the errors are those of the URDF's bodies with this payload, and with friction and rotors as "
    "they were found; what the controller itself computes is not known"
)
OWN = (
    "the controller's own arm and friction stay as they are: a program can set neither links, "
    "rotors nor effects"
)


def write(model: Model, path: Path, options: Options) -> Exported:
    """Write a program; see `Format`."""
    if model.data.effort == "without-gravity":
        raise ExportError(
            "the model's torque is without gravity, in which no payload has weight: identify it "
            "from efforts that hold gravity"
        )
    robot, _ = read(options, model)
    load, found, frame = _payload(model, robot, options)
    scales = _scales(model, options.earlier)
    lines = [
        f"# Made by lagrangian_ff from the model {model.name} of {len(model.joints)} joints.",
        "# kg, m and kg*m^2 in the frame of the flange; the inertia about the centre of gravity is",
        "# Ixx, Iyy, Izz, Ixy, Ixz, Iyz.",
        f"set_target_payload({load.mass:.4f}, {_listed(load.centre)}, "
        f"{_listed(load.inertia[(0, 1, 2, 0, 0, 1), (0, 1, 2, 1, 2, 2)], 6)})",
    ]
    hung = f"the payload is what hangs on {frame} beside the bodies of the URDF"
    notes = [TORQUES, OWN, BESIDE, hung]
    if scales is None:
        notes.append(
            "no friction scales: they are parts of the controller's own friction, which is not "
            "published; --earlier MODEL of this arm stands for it"
        )
    else:
        lines += [
            "# For direct_torque, as viscous_scale and coulomb_scale of ur_msgs: friction in parts",
            "# of that of the earlier model, 0 to 1.",
            *(f"{name}_scale = {_listed(np.clip(one, 0.0, 1.0))}" for name, one in scales.items()),
        ]
        beyond = [name for name, one in scales.items() if (one > 1.0).any()]
        if beyond:
            notes.append(f"friction grew: {' and '.join(beyond)} scales above 1 are written as 1")
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    held = {
        "mass": load.mass,
        "centre": load.centre.tolist(),
        "inertia": load.inertia.tolist(),
        **{f"{name}_scale": one.tolist() for name, one in (scales or {}).items()},
    }
    return exported(model, NAME, (".",), found.torque, found.losses, tuple(notes), held)


def _payload(model: Model, robot: Robot, options: Options) -> tuple[Inertial, Fit, str]:
    """Return the load in the frame of the flange, the fit, and the flange's name.

    It is a body more, on the same joint as the last one; all others are those of the URDF.
    """
    joint, turn, place = _flange(options)
    if joint not in robot.movable:
        raise ModelError(f"{options.urdf}: {options.flange} hangs on no joint of the arm")
    carrier, tree = robot.movable.index(joint), robot.tree
    # On a joint that stands still, so that its frame is that of the flange.
    added = {
        "parent": carrier, "driver": -1, "rotation": turn, "offset": place, "axis": np.eye(3)[2],
        "sliding": 0.0, "ratio": 1.0, "shift": 0.0,
        "inertial": START,
    }  # fmt: skip
    carrying = replace(
        tree,
        **{
            name: np.concatenate([getattr(tree, name), np.array([one])])
            for name, one in added.items()
        },
    )
    names = (*robot.movable, options.flange)
    loaded = replace(robot, tree=carrying, movable=names)
    found = fit(model, loaded, armature=True, free=(tree.bodies,), deviation=DEVIATION)
    return Inertial.of(found.inertial[-1]), found, options.flange


def _flange(options: Options) -> tuple[str, Floats, Floats]:
    """Return the joint that moves the flange, and where the flange is in its frame."""
    from pinocchio import buildModelFromXML  # read_urdf has required it

    assert options.urdf is not None
    built = buildModelFromXML(options.urdf.read_text(encoding="utf-8"))
    if not built.existFrame(options.flange):
        links = ", ".join(str(one.name) for one in built.frames if "universe" not in str(one.name))
        raise ExportError(
            f"{options.urdf} has no link {options.flange}: name the one that the tool is fastened "
            f"to with --flange; there are {links}"
        )
    frame = built.frames[built.getFrameId(options.flange)]
    return (
        str(built.names[frame.parentJoint]),
        np.array(frame.placement.rotation),
        np.array(frame.placement.translation),
    )


def _scales(model: Model, earlier: Model | None) -> dict[str, Floats] | None:
    """Return viscous and Coulomb friction in parts of an earlier model's."""
    if earlier is None:
        return None
    if earlier.joints != model.joints:
        raise ExportError(
            f"--earlier is a model of {', '.join(earlier.joints)}, not of {', '.join(model.joints)}"
        )
    found = {}
    for name in FRICTION:
        now, before = _coefficients(model, name), _coefficients(earlier, name)
        if not (before > 0.0).all():
            none = [one for one, b in zip(model.joints, before, strict=True) if b <= 0.0]
            raise ExportError(
                f"--earlier has no {name} friction above 0 on {', '.join(none)}, so that nothing "
                "can be a part of it"
            )
        found[name] = now / before
    return found


def _coefficients(model: Model, effect: str) -> Floats:
    out = np.zeros(len(model.joints))
    for term, place in model.basis.slices():
        if term.effect.name == effect:
            out[term.joint] += float(model.coefficients[place][0])
    return out


def _listed(values: Floats, digits: int = 4) -> str:
    return "[" + ", ".join(f"{value:.{digits}f}" for value in values) + "]"
