"""What the commands share: options, sources, outputs, progress and where text goes."""
