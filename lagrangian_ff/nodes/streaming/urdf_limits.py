"""The torque limits a robot description states."""

from xml.etree import ElementTree

from lagrangian_ff.nodes.common.errors import MessageError


def effort_limits(urdf: str) -> dict[str, float]:
    """N·m (N for prismatic joints) by joint, for the joints that have a positive limit.

    Raises:
        MessageError: the text is not a URDF.
    """
    try:
        root = ElementTree.fromstring(urdf)
    except ElementTree.ParseError as error:
        raise MessageError(f"robot_description is not XML: {error}") from None
    found = {}
    for joint in root.iter("joint"):
        limit = joint.find("limit")
        try:
            effort = float(limit.get("effort", "0")) if limit is not None else 0.0
        except ValueError:
            raise MessageError(
                f"robot_description: the effort limit of {joint.get('name')} is no number"
            ) from None
        if 0.0 < effort < float("inf"):
            found[joint.get("name", "")] = effort
    return found
