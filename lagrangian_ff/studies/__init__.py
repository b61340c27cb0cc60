"""Studies at full size, each reproducible from its seed."""
