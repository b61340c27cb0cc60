"""The parameters of the node that records and identifies."""

from collections.abc import Sequence

from lagrangian_ff.nodes.common.parameters import Parameters


def declare(parameters: Parameters) -> None:
    """Declare all that does not depend on the joints."""
    add = parameters.declare
    add("joints", [""], 'joints to identify, in this order; [""] = all recorded ones')
    add("model", "auto+fri", "model to identify, a sum of kernels and bases")
    add("prismatic", [""], 'joints that slide, in m and N, where no urdf says it; [""] = all turn')
    add("urdf", "", "file of the robot's description, whose rigid bodies are part of the model; "
        "empty = none")  # fmt: skip
    add("use_robot_description", False, "take the description from the topic robot_description")
    add("train", 2.0 / 3.0, "fraction of the motion to train on, the rest is held out",
        low=0.01, high=1.0)  # fmt: skip
    add("samples", 500, "samples to train on", low=10, high=20_000)
    add("landmarks", -1, "samples the kernel is built on, all being learned from; 0 = an exact "
        "model of `samples`, -1 = exact up to two minutes of training motion, else 300",
        low=-1, high=20_000)  # fmt: skip
    add("positive", False, "whether the mass matrix is kept positive definite along the training "
        "motion")  # fmt: skip
    add("loss", "square", "what a residual costs; huber weighs down contacts and gross errors",
        choices=("square", "huber"))  # fmt: skip
    add("bandwidth", 25.0, "Hz of the low-pass on position and effort", low=0.5, high=500.0)
    add("output_directory", ".", "where bags, models and findings are written")
    add("bag_prefix", "recording", "how the names of bags begin")
    add("model_file", "", "the model to compare, diagnose and add to until one is identified, and "
        "where ~/save puts the last one (empty = model.npz in output_directory)")  # fmt: skip
    add("identify_on_stop", False, "whether ~/stop begins the identification, too")
    add("add.effect", "", "the effect that ~/add adds, as lagrangian_ff effects names it; empty = "
        "what the last diagnosis confirmed")  # fmt: skip
    add("add.joint", "", "the joint that ~/add adds it to")
    add("effects_file", "", "Python that defines effects of your own; empty = none")


def declare_joints(parameters: Parameters, joints: Sequence[str]) -> None:
    """Declare what each joint has."""
    for joint in joints:
        parameters.declare(
            f"effort_scale.{joint}", 1.0, "N·m per unit of effort", low=-1e6, high=1e6
        )
        parameters.declare(
            f"effort_offset.{joint}", 0.0, "N·m added after scaling", low=-1e6, high=1e6
        )
