"""Records as JSON, the same from the command line and from the nodes."""

import json
import math
from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass
from types import UnionType
from typing import Any, ClassVar, Protocol, TypeVar, get_args, get_origin

Json = Mapping[str, Any]


class _Dataclass(Protocol):
    __dataclass_fields__: ClassVar[dict[str, Any]]


Made = TypeVar("Made", bound=_Dataclass)


def to_json(record: Mapping[str, object]) -> str:
    """Return a record as text; numbers that are not finite become null."""
    return json.dumps(finite(record), indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def finite(value: Any) -> Any:
    """Return the value as dicts, lists and scalars; numbers that are not finite are None."""
    if isinstance(value, Mapping):
        return {str(key): finite(inner) for key, inner in value.items()}
    if isinstance(value, list | tuple):
        return [finite(inner) for inner in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def by_name(value: _Dataclass) -> dict[str, Any]:
    """Return the fields of a result by name, as JSON holds them; parts with a `record` give it."""
    return {field.name: _plain(getattr(value, field.name)) for field in fields(value)}


def _plain(value: Any) -> Any:
    if hasattr(value, "record"):
        return value.record()
    if is_dataclass(value) and not isinstance(value, type):
        return by_name(value)
    if isinstance(value, Mapping):
        return {name: _plain(one) for name, one in value.items()}
    if isinstance(value, tuple):
        return [_plain(one) for one in value]
    return value.tolist() if hasattr(value, "tolist") else value  # NumPy's


def given(record: Mapping[str, Any]) -> dict[str, Any]:
    """Return the fields that are not None."""
    return {name: value for name, value in record.items() if value is not None}


def read(kind: type[Made], record: Json, **how: Callable[[Any], Any]) -> Made:
    """Return a result from its JSON; what is missing or null has its default.

    Args:
        kind: of the result; the types of its fields say which parts are results or tuples.
        record: may hold other fields, too.
        how: by name, the readers of fields that JSON holds in another form.

    Raises:
        TypeError: a field holds what its type does not allow; names field, value and type.
    """
    types = {field.name: field.type for field in fields(kind)}
    _require(record, Mapping, kind.__name__, "an object")
    held = {name: value for name, value in given(record).items() if name in types}
    made = {n: how[n](v) if n in how else _made(types[n], v, n) for n, v in held.items()}
    return kind(**made)


def _made(kind: Any, value: Any, name: str) -> Any:
    """Return a value of JSON as the type of a field has it."""
    outer, inner = get_origin(kind), get_args(kind)
    if isinstance(kind, type) and is_dataclass(kind):
        return read(kind, value)
    if outer is UnionType:  # X | None
        return _made(inner[0], value, name)
    if outer is tuple:
        _require(value, list | tuple, name, "a list")
        return tuple(_made(inner[0], one, name) for one in value)
    if outer is Mapping:
        _require(value, Mapping, name, "an object")
        return {key: _made(inner[1], one, name) for key, one in value.items()}
    if kind is float and value is None:  # JSON has no number that is not finite
        return math.nan
    if kind in _SIMPLE:
        expected, words = _SIMPLE[kind]
        _require(value, expected, name, words)
        if isinstance(value, bool) and kind is not bool:
            raise TypeError(f"{name} is {value}, expected {words}")
    return value


_SIMPLE: Mapping[Any, tuple[Any, str]] = {
    float: (int | float, "a number"),
    int: (int, "a whole number"),
    bool: (bool, "true or false"),
    str: (str, "a text"),
}


def _require(value: Any, kind: Any, name: str, words: str) -> None:
    if not isinstance(value, kind):
        raise TypeError(f"{name} is {str(value)[:40]!r}, expected {words}")
