"""What a Lagrangian tells beyond torque, and a mass matrix that is one."""
