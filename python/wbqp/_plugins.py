"""Classes of the plug-ins, made from the registry's JSON Schema: one for each task, constraint, reference, robot …

An object of such a class is what a configuration says of a plug-in: its keys, with the names and defaults of the files.
"""

from __future__ import annotations

import copy
import difflib
import inspect
import json
import keyword
import re
from typing import Any

import numpy as np

from . import _wbqp

_KINDS = {
    "tasks": "task",
    "constraints": "constraint",
    "references": "reference",
    "robots": "robot",
    "solvers": "solver",
    "fallbacks": "fallback",
}


class Plugin:
    """What a configuration says of a plug-in. Keys that are not given have the configuration's defaults."""

    _tag: str | None = None
    _schema: dict[str, Any] = {}

    def __init__(self, **keys: Any) -> None:
        cls = type(self)
        keys = {cls._known(key): value for key, value in keys.items()}
        missing = [repr(key) for key in cls._schema.get("required", []) if key != "type" and key not in keys]
        if missing:
            raise TypeError(f"{cls.__name__} needs {', '.join(missing)}")
        object.__setattr__(self, "_keys", keys)

    @classmethod
    def _known(cls, key: str) -> str:
        """The key of a file that an argument is for."""
        known = cls._schema["properties"]
        key = key[:-1] if keyword.iskeyword(key[:-1]) else key
        if key not in known or (key == "type" and cls._tag is not None):
            close = difflib.get_close_matches(key, known, 1, 0.5)
            hint = f"; did you mean {close[0]!r}?" if close else ""
            names = ", ".join(name for name in known if name != "type")
            raise TypeError(f"{cls.__name__} has no key {key!r}{hint} (known: {names})")
        return key

    def __setattr__(self, key: str, value: Any) -> None:
        try:
            self._keys[self._known(key)] = value
        except TypeError as error:
            raise AttributeError(str(error)) from None

    def __getattr__(self, key: str) -> Any:
        if not key.startswith("_"):
            key = key[:-1] if keyword.iskeyword(key[:-1]) else key
            if key in self._keys:
                return self._keys[key]
            about = type(self)._schema["properties"].get(key)
            if about is not None:
                # Its own: the schema's stays what it is.
                return copy.deepcopy(about.get("default"))
        raise AttributeError(f"{type(self).__name__} has no {key!r}")

    def _wbqp_table(self) -> dict[str, Any]:
        tag = {} if self._tag is None else {"type": self._tag}
        return {**tag, **{key: value for key, value in self._keys.items() if value is not None}}

    def __eq__(self, other: object) -> bool:
        return type(other) is type(self) and _same(other._keys, self._keys)  # type: ignore[attr-defined]

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        keys = ", ".join(f"{python_name(key)}={value!r}" for key, value in self._keys.items())
        return f"{type(self).__module__}.{type(self).__name__}({keys})"


def _same(a: Any, b: Any) -> bool:
    """Whether two values are equal, arrays among them or not."""
    if isinstance(a, np.ndarray) or isinstance(b, np.ndarray):
        return np.shape(a) == np.shape(b) and bool(np.all(np.asarray(a) == np.asarray(b)))
    if isinstance(a, dict) and isinstance(b, dict):
        return a.keys() == b.keys() and all(_same(value, b[key]) for key, value in a.items())
    return bool(a == b)


def python_name(key: str) -> str:
    """The argument of a key: ``from`` is a word of Python's, and called ``from_``."""
    return f"{key}_" if keyword.iskeyword(key) else key


def class_name(tag: str) -> str:
    """``frame_pose`` is ``FramePose``."""
    return "".join(part.capitalize() for part in re.split(r"[^0-9A-Za-z]+", tag))


def annotation(about: dict[str, Any]) -> str:
    """The Python type of a value that a JSON Schema describes."""
    if not isinstance(about, dict):
        return "Any"
    if "enum" in about and all(isinstance(value, str) for value in about["enum"]) and "allOf" not in about:
        return f"Literal[{', '.join(repr(value) for value in about['enum'])}]"
    if "allOf" in about:
        return "Plugin | dict[str, Any]"
    branches = about.get("anyOf") or about.get("oneOf")
    if branches:
        names = list(dict.fromkeys(name for branch in branches for name in annotation(branch).split(" | ")))
        return "Any" if "Any" in names else " | ".join(name for name in names if name != "None") or "Any"
    kinds = about.get("type")
    kinds = [kinds] if isinstance(kinds, str) else kinds or []
    names = []
    for kind in kinds:
        if kind == "array":
            items = about.get("items")
            inner = annotation(items) if isinstance(items, dict) else "float"
            names.append(f"Sequence[{inner}]")
        elif kind == "object":
            names.append("dict[str, Any]")
        elif kind != "null":
            names.append({"number": "float", "integer": "int", "boolean": "bool", "string": "str"}[kind])
    return " | ".join(names) or "Any"


def _document(text: str, schema: dict[str, Any]) -> str:
    # Links of Rust's documentation lead nowhere here.
    text = re.sub(r"\[([^\]]+)\]\([^)]*\)", r"\1", text)
    lines = [text.strip() or "No description.", "", "Parameters", "----------"]
    required = schema.get("required", [])
    for key, about in _ordered(schema):
        kind = annotation(about)
        if key not in required:
            default = about.get("default")
            kind += ", optional" if default is None else f", default {json.dumps(default, ensure_ascii=False)}"
        unit = about.get("x-unit")
        what = (about.get("description") or "").strip().split("\n")
        if unit and not any(unit in line for line in what):
            what[-1] += f" [{unit}]"
        lines.append(f"{python_name(key)} : {kind}")
        lines.extend(f"    {line}".rstrip() for line in what)
    return "\n".join(lines)


def _ordered(schema: dict[str, Any]) -> list[tuple[str, dict[str, Any]]]:
    required = schema.get("required", [])
    properties = [(key, about) for key, about in schema["properties"].items() if key != "type"]
    return sorted(properties, key=lambda item: item[0] not in required)


def _signature(schema: dict[str, Any]) -> inspect.Signature:
    required = schema.get("required", [])
    named = inspect.Parameter.KEYWORD_ONLY
    parameters = [inspect.Parameter("self", inspect.Parameter.POSITIONAL_OR_KEYWORD)]
    for key, about in _ordered(schema):
        default = inspect.Parameter.empty if key in required else about.get("default")
        parameters.append(inspect.Parameter(python_name(key), named, default=default, annotation=annotation(about)))
    return inspect.Signature(parameters, return_annotation=None)


def _make(name: str, module: str, tag: str | None, schema: dict[str, Any]) -> type[Plugin]:
    def __init__(self: Plugin, **keys: Any) -> None:
        Plugin.__init__(self, **keys)

    __init__.__signature__ = _signature(schema)  # type: ignore[attr-defined]
    contents = {
        "__doc__": _document(schema.get("description", ""), schema),
        "__module__": module,
        "__init__": __init__,
        "_tag": tag,
        "_schema": schema,
    }
    return type(name, (Plugin,), contents)


_SCHEMA: dict[str, Any] = json.loads(_wbqp._schema())


def classes(module: str) -> dict[str, type[Plugin]]:
    """The classes of a module: ``tasks``, ``constraints``, ``references``, ``robots``, ``solvers``, ``fallbacks``."""
    kind = _KINDS[module]
    found = {}
    for name, schema in sorted(_SCHEMA["$defs"].items()):
        of, _, tag = name.partition(".")
        if of == kind and tag != "python.robot":
            found[class_name(tag)] = _make(class_name(tag), f"wbqp.{module}", tag, schema)
    return found


def contact() -> type[Plugin]:
    """The class of contacts."""
    return _make("Contact", "wbqp", None, _SCHEMA["properties"]["contact"]["items"])
