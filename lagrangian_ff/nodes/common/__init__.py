"""The parts that all nodes share."""
