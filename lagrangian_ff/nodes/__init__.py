"""The ROS 2 nodes: thin shells around the rooms below.

`identify`, `feedforward`, `monitor` and `arm` are the executables; the workbench starts `live`.
What they share lies in `common`; the logic of the streamed torque in `streaming`, of the recorder
in `recorder`, of the monitor in `watching`, of `live` in `attached`, nearly all free of rclpy so
that it is tested without an executor.

Not real time, not a safety function: a controller that takes the torque must have its own
limits and its own timeout.
"""
