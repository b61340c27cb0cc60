"""The files that findings are written to."""

import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from lagrangian_ff.errors import UserError
from lagrangian_ff.record_json import to_json


def write_json(path: Path, record: Mapping[str, Any]) -> None:
    """Write a record whole or not at all; numbers that are not finite become null.

    Raises:
        OSError: it cannot be written.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_name(f"{path.name}.part")
    part.write_text(to_json(record), "utf-8")
    os.replace(part, path)


def write_page(
    make: Callable[[Path, Mapping[str, Any]], Path], beside: Path, record: Mapping[str, Any]
) -> dict[str, str]:
    """Write the page beside a file; its name, or why there is none: the findings stand alone."""
    path = beside.with_suffix(".html")
    try:
        return {"page": str(make(path, record))}
    except (UserError, OSError) as error:
        return {"page": "", "page_failure": str(error)}
