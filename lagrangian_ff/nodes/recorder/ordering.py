"""From a session and the parameters to an order."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from lagrangian_ff.errors import UserError
from lagrangian_ff.nodes.recorder.order import Addition, Order, Task
from lagrangian_ff.nodes.recorder.session import Session, new_path

Value = Callable[[str], Any]


def make_order(
    task: Task,
    session: Session,
    value: Value,
    topic: str,
    joints: Sequence[str],
    description: str = "",
) -> Order:
    """What is to be done now.

    Args:
        task: which kind of work.
        session: tells the recordings and the model.
        value: of a parameter.
        topic: of the joint states.
        joints: those with parameters of their own.
        description: the URDF that came on robot_description; empty if none did.

    Raises:
        UserError: there is no model, nothing to add, or no description of the robot where one is
            asked for.
    """
    bags = tuple(map(str, session.bags))
    common: dict[str, Any] = {
        "task": task,
        "topic": topic,
        "effects_file": _path(value("effects_file")),
        "effort_scale": {joint: value(f"effort_scale.{joint}") for joint in joints},
        "effort_offset": {joint: value(f"effort_offset.{joint}") for joint in joints},
    }
    directory = directory_of(value)
    if task is Task.IDENTIFY:
        stem = f"{session.bags[-1].name}_model"
        return Order(
            **common,
            bags=bags,
            output=str(new_path(directory, stem, ".npz")),
            urdf=_urdf(value, description, new_path(directory, stem, ".urdf")),
            joints=_names(value("joints")),
            model=value("model"),
            prismatic=_names(value("prismatic")),
            train=value("train"),
            samples=value("samples"),
            landmarks=value("landmarks") if value("landmarks") >= 0 else None,
            positive=value("positive"),
            loss=value("loss"),
            bandwidth=value("bandwidth"),
        )
    model = present_model(session, value)
    common["model_file"] = str(model)
    if task is Task.ADD:
        additions = _additions(session, value)
        stem = "_".join([model.stem, *(f"{each.effect}_{each.joint}" for each in additions)])
        output = str(new_path(model.parent, stem.replace("/", "_"), ".npz"))
        return Order(**common, output=output, additions=additions)
    stem = f"{session.bags[-1].name}_{task.value}"
    output = str(new_path(directory, stem, ".json"))
    if task is Task.COMPARE:
        return Order(**common, bags=bags[-1:], output=output)
    # The only recording confirms with its own end.
    first, last = (bags[:-1], bags[-1:]) if len(bags) > 1 else (bags, ())
    return Order(**common, bags=first, confirm=last, output=output)


def summary(order: Order) -> str:
    """What is begun, in words."""
    names = ", ".join(Path(bag).name for bag in order.bags)
    model = Path(order.model_file).name
    if order.task is Task.IDENTIFY:
        return f"started to identify {order.model} from {names}"
    if order.task is Task.COMPARE:
        return f"started to compare {model} with {names}"
    if order.task is Task.ADD:
        added = " and ".join(map(str, order.additions))
        return f"started to add {added} to {model}; it becomes {order.output}"
    last = ", ".join(Path(bag).name for bag in order.confirm)
    return f"started to diagnose {model} on {names}; " + (
        f"{last} confirms" if last else "its last third is held back and confirms"
    )


def directory_of(value: Value) -> Path:
    """Where bags, models and findings are written."""
    return Path(_path(value("output_directory")))


def saved_model(value: Value) -> Path:
    """Where ~/save puts the model."""
    wanted = value("model_file")
    return Path(_path(wanted)) if wanted else directory_of(value) / "model.npz"


def present_model(session: Session, value: Value) -> Path:
    """The last model of the session, else the one that `model_file` names.

    Raises:
        UserError: there is neither.
    """
    if session.result is not None:
        return session.result.model
    wanted = value("model_file")
    if not wanted:
        raise UserError(
            "no model: call ~/identify first, or name the file of one with the parameter model_file"
        )
    path = Path(_path(wanted))
    if not path.is_file():
        raise UserError(
            f"no model: the parameter model_file names {path}, which does not exist; call "
            "~/identify first, or name a model that exists"
        )
    return path


def _additions(session: Session, value: Value) -> tuple[Addition, ...]:
    effect, joint = value("add.effect"), value("add.joint")
    if effect and joint:
        return (Addition(effect, joint, why={"why": "a person asked for it"}),)
    if effect or joint:
        missing = "add.joint" if effect else "add.effect"
        raise UserError(f"nothing to add: set the parameter {missing}, too, or leave both empty")
    if Task.DIAGNOSE not in session.found:
        raise UserError(
            "nothing to add: call ~/diagnose first, or name an effect and a joint with the "
            "parameters add.effect and add.joint"
        )
    confirmed = session.confirmed()
    if not confirmed:
        raise UserError(
            "nothing to add: the last diagnosis confirmed no effect; to add one all the same, "
            "name it with the parameters add.effect and add.joint"
        )
    return confirmed


def _urdf(value: Value, description: str, file: Path) -> str:
    """The file of the robot's description; what came on the topic is written to one."""
    named = _path(value("urdf"))
    if not value("use_robot_description"):
        return named
    if named:
        raise UserError(
            "the parameter urdf names a file and use_robot_description asks for the topic: "
            "set one of the two"
        )
    if not description:
        raise UserError(
            "use_robot_description is set, but nothing came on the topic robot_description; start "
            "robot_state_publisher, or name a file with the parameter urdf"
        )
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(description, encoding="utf-8")
    return str(file)


def _names(texts: Sequence[str]) -> tuple[str, ...]:
    return tuple(name for name in texts if name)


def _path(text: str) -> str:
    return str(Path(text).expanduser().absolute()) if text else ""
