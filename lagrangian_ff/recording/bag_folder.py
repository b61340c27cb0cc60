"""Which folder is a bag."""

from pathlib import Path

DATA = (".mcap", ".db3", ".zstd")


def is_bag(path: Path) -> bool:
    """Whether a folder holds nothing but a bag's files, so that it may be replaced."""
    return all(
        file.name.startswith("metadata.yaml") or file.suffix in DATA for file in path.iterdir()
    )
