"""Section V: how few centres do, and what they save."""
