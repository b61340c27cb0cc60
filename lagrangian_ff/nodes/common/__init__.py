"""What every node does the same way: running, pacing, parameters, QoS, diagnostics, warnings."""
