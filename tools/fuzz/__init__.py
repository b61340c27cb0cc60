"""Damaged files for every reader, and a judge of what the readers do with them."""
