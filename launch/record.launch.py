"""The recorder beside a real robot that publishes joint states.

    ros2 launch lagrangian_ff record.launch.py joint_states:=/joint_states

Then call identify/start, move the robot, call identify/stop, identify/identify, identify/save.
Later, with model_file: start and stop once more, then identify/compare, identify/diagnose and
identify/add.
"""

from launch import LaunchDescription

from lagrangian_ff.nodes.launching import describe_beside_robot


def generate_launch_description() -> LaunchDescription:
    """Return the arguments and the node."""
    return describe_beside_robot(
        "identify",
        "parameters of the recorder: joints, model, effort_scale, ...",
        {
            "model_file": "the model to compare and diagnose, and where identify/save puts the "
            "last one",
            "output_directory": "where bags, models and findings are written",
        },
        does="record",
    )
