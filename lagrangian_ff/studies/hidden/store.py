"""Recordings of the cases that are kept in the study's folder."""

import json
from pathlib import Path
from typing import Any

from lagrangian_ff.recording import load, write_npz
from lagrangian_ff.recording.recording import Recording
from lagrangian_ff.studies.hidden.cases import Case
from lagrangian_ff.studies.hidden.plants import Stretches, record


def recorded(
    case: Case, folder: Path, stretches: Stretches, *, keep: bool = False
) -> tuple[Recording, Recording, dict[str, Any]]:
    """The recordings of a case; with `keep` from the folder, or made and kept there."""
    place = folder / "recordings" / case.name
    paths, about = [place / f"{number}.npz" for number in (1, 2)], place / "info.json"
    if keep and about.is_file():
        first, second = (load(path) for path in paths)
        return first, second, json.loads(about.read_text(encoding="utf-8"))
    first, second, plant = record(case, folder, stretches)
    if keep:
        place.mkdir(parents=True, exist_ok=True)
        for path, each in zip(paths, (first, second), strict=True):
            write_npz(path, each)
        part = about.with_suffix(".part")
        part.write_text(json.dumps(plant, indent=1, ensure_ascii=False), encoding="utf-8")
        part.replace(about)
    return first, second, plant
