"""Profiles of arms: parameters for a driver in a file, by name."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import yaml
from ament_index_python.packages import PackageNotFoundError, get_package_share_directory

from lagrangian_ff.errors import UserError

SOURCE = Path(__file__).resolve().parents[3]


def read_profile(name: str) -> dict[str, Any]:
    """Return the parameters of a profile by their names.

    Args:
        name: of a file in config/arms without its ending, or the path of another file; "" is none.

    Raises:
        UserError: there is no such profile, or it is no file of parameters; says which there are.
    """
    if not name:
        return {}
    if name.endswith((".yaml", ".yml")):
        path = Path(name).expanduser()
    else:
        path = _folder() / f"{name}.yaml"
    try:
        tree = yaml.safe_load(path.read_text(encoding="utf-8"))
        given = tree["/**"]["ros__parameters"]
        return dict(_flat(given))
    except OSError as error:
        known = ", ".join(sorted(one.stem for one in _folder().glob("*.yaml")))
        said = f"there is no profile {name} ({error.strerror}: {path}); there are {known}"
        raise UserError(said) from None
    except (yaml.YAMLError, KeyError, TypeError, AttributeError, UnicodeDecodeError) as error:
        raise UserError(
            f"{path} is no file of parameters (/**: ros__parameters: ...): {error}"
        ) from None


def _folder() -> Path:
    """Return where the profiles lie: installed, or in the source."""
    try:
        installed = Path(get_package_share_directory("lagrangian_ff")) / "config" / "arms"
    except (PackageNotFoundError, LookupError, OSError):  # no ROS is sourced
        return SOURCE / "config" / "arms"
    return installed if installed.is_dir() else SOURCE / "config" / "arms"


def _flat(tree: Mapping[str, Any], before: str = "") -> Iterator[tuple[str, Any]]:
    for name, value in tree.items():
        if isinstance(value, Mapping):
            yield from _flat(value, f"{before}{name}.")
        else:
            yield f"{before}{name}", value
