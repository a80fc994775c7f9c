"""From keywords to the tables of a controller's file."""

from __future__ import annotations

from typing import Any

_TABLES = {"robot": "robot", "solver": "solver", "fallback": "fallback", "measurement": "measurement"}
_LISTS = {"contacts": "contact", "tasks": "task", "constraints": "constraint"}


def document(**keywords: Any) -> dict[str, Any]:
    """The tables of a controller's file, made of the constructor's keywords."""
    tables: dict[str, Any] = {"controller": {}}
    for key, value in keywords.items():
        if value is None:
            continue
        if key in _LISTS:
            tables[_LISTS[key]] = list(value)
        elif key in _TABLES:
            tables[_TABLES[key]] = {"type": value} if isinstance(value, str) else value
        else:
            tables["controller"][key] = value
    return tables
