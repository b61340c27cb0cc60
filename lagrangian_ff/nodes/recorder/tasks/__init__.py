"""What the worker process does, one task a file; each returns the record that the node shows."""
