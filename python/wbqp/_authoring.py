"""Plug-ins written in Python: the decorators, what ``bind`` returns, and what ``update`` sees and writes."""

from __future__ import annotations

import dataclasses
import inspect
import json
import types
import typing
from collections.abc import Callable, Sequence
from typing import Any, TypeVar

import numpy as np

from . import _wbqp

C = TypeVar("C", bound=type)


@dataclasses.dataclass(frozen=True)
class Layout:
    """What a task or constraint declares in ``bind``.

    Parameters
    ----------
    rows : list of (label, unit)
        One for each row: ``[("about x", "rad/s²"), ("about y", "rad/s²")]``.
    error_unit : str, optional
        Unit of a task's error.
    vdot, effort : bool
        Whether rows have coefficients on accelerations, and on efforts.
    forces : list of str
        Contacts on whose forces rows have coefficients.
    contact : str, optional
        The contact that the rows belong to: they follow its switch.
    equality : bool
        Of a constraint: ``A x = target`` instead of ``lower ≤ A x ≤ upper``.
    """

    rows: Sequence[tuple[str, str]]
    error_unit: str | None = None
    vdot: bool = True
    effort: bool = False
    forces: Sequence[str] = ()
    contact: str | None = None
    equality: bool = False


class Tick:
    """What is known in a tick; all arrays are read-only, in world axes unless they say otherwise.

    Attributes
    ----------
    position, quaternion, q, v : array
        Measured state; the quaternion is w-x-y-z.
    M, h : array (nv, nv) and (nv,)
        Mass matrix and bias.
    com, com_velocity, com_jacobian, com_bias : array
        Centre of mass.
    last_vdot, last_effort : array
        Of the last tick.
    """

    def __init__(
        self, arrays: dict[str, np.ndarray], frames: list[dict[str, np.ndarray]], contacts: dict[str, Any]
    ) -> None:
        self.__dict__.update(arrays)
        self._frames = [types.SimpleNamespace(**frame) for frame in frames]
        self._contacts = {name: types.SimpleNamespace(**contact) for name, contact in contacts.items()}

    @property
    def time(self) -> float:
        """Time since the controller's first tick, s."""
        return float(self._scalars[0])

    @property
    def period(self) -> float:
        """Control period, s."""
        return float(self._scalars[1])

    @property
    def elapsed(self) -> float:
        """Time that this tick stands for, s: what integrals grow by."""
        return float(self._scalars[2])

    @property
    def alpha(self) -> float:
        """The entry's ramp, 0 to 1."""
        return float(self._scalars[3])

    def frame(self, handle: int) -> Any:
        """A frame that ``bind`` asked for: ``position``, ``rotation`` (3, 3), ``velocity`` (6,), ``J`` (6, nv),
        ``Jdot_v``."""
        return self._frames[handle]

    def contact(self, name: str) -> Any:
        """A contact, in its axes: ``live``, ``position``, ``velocity``, ``measured``, ``solution``, ``J``,
        ``Jdot_v``."""
        return self._contacts[name]

    if typing.TYPE_CHECKING:

        def __getattr__(self, name: str) -> np.ndarray: ...


class Rows:
    """What an update writes: into the arrays, or by assigning to them, which copies.

    Attributes
    ----------
    vdot : array (rows, nv)
        Coefficients on accelerations, if the layout has them.
    effort : array (rows, nu)
        Coefficients on efforts, if the layout has them.
    target : array (rows,)
        Of tasks and equalities: what ``A x`` should be, with ``bias`` still to be taken off.
    bias : array (rows,)
        ``J̇ v`` of the rows on accelerations; zero unless it is written.
    error : array (rows,)
        Of tasks: actual minus desired.
    lower, upper : array (rows,)
        Of constraints: limits of ``A x``; infinite unless they are written.
    """

    def __init__(self, arrays: dict[str, np.ndarray], forces: dict[str, np.ndarray]) -> None:
        object.__setattr__(self, "_arrays", arrays)
        object.__setattr__(self, "_forces", forces)

    def __getattr__(self, name: str) -> np.ndarray:
        try:
            return typing.cast(np.ndarray, self._arrays[name])
        except KeyError:
            raise AttributeError(f"rows have no {name!r}: declared are {', '.join(self._arrays)}") from None

    def __setattr__(self, name: str, value: Any) -> None:
        getattr(self, name)[...] = value

    def force(self, contact: str) -> np.ndarray:
        """Coefficients on the forces of a contact that the layout names, shape (rows, components)."""
        return typing.cast(np.ndarray, self._forces[contact])

    def motion(
        self,
        row: int,
        *,
        error: float,
        rate: float,
        kp: float,
        kd: float | None = None,
        acceleration: float = 0.0,
        J: Any = None,
        bias: float | None = None,
    ) -> None:
        """Writes a row on motion: ``J v̇ = acceleration − kd rate − kp error − bias``; critically damped without kd."""
        damping = 2.0 * kp**0.5 if kd is None else kd
        self.error[row] = error
        self.target[row] = acceleration - damping * rate - kp * error
        if J is not None:
            self.vdot[row] = J
        if bias is not None:
            self.bias[row] = bias


def _json_type(annotation: Any) -> dict[str, Any]:
    simple = {float: "number", int: "integer", bool: "boolean", str: "string"}
    if annotation in simple:
        return {"type": simple[annotation]}
    origin = typing.get_origin(annotation)
    arguments = typing.get_args(annotation)
    if origin in (typing.Union, types.UnionType):
        real = [argument for argument in arguments if argument is not type(None)]
        if len(real) == 1:
            return _json_type(real[0])
        return {"anyOf": [_json_type(argument) for argument in real]}
    if origin is typing.Literal:
        return {"enum": list(arguments)}
    if annotation in (list, tuple, np.ndarray) or (isinstance(origin, type) and issubclass(origin, Sequence)):
        items = [argument for argument in arguments if argument is not ...]
        return {"type": "array", "items": _json_type(items[0])} if items else {"type": "array"}
    if annotation is dict or origin is dict:
        return {"type": "object"}
    return {}


def _fields(cls: type) -> dict[str, dict[str, Any]]:
    """Schema of each key; those that must be there have no ``default`` and no ``optional``."""
    hints = typing.get_type_hints(cls)
    found: dict[str, dict[str, Any]] = {}
    if dataclasses.is_dataclass(cls):
        for field in dataclasses.fields(cls):
            if not field.init:
                continue
            about = _json_type(hints[field.name])
            if field.default is not dataclasses.MISSING:
                about["default"] = field.default
            elif field.default_factory is not dataclasses.MISSING:
                about["default"] = field.default_factory()
            if "unit" in field.metadata:
                about["x-unit"] = field.metadata["unit"]
            about["description"] = field.metadata.get("description", field.name)
            found[field.name] = about
    else:
        for name, annotation in hints.items():
            if name.startswith("_") or typing.get_origin(annotation) is typing.ClassVar:
                continue
            about = _json_type(annotation)
            if hasattr(cls, name):
                about["default"] = getattr(cls, name)
            about["description"] = name
            found[name] = about
    return found


def _check_type(name: str, value: Any, about: dict[str, Any]) -> Any:
    kind = about.get("type")
    numbers = (int, float)
    if kind == "number":
        if isinstance(value, bool) or not isinstance(value, numbers):
            raise TypeError(f"`{name}` must be a number, is {value!r}")
        return float(value)
    expected: Any = {"integer": int, "boolean": bool, "string": str, "array": list, "object": dict}.get(kind or "")
    if expected is not None and (not isinstance(value, expected) or (kind == "integer" and isinstance(value, bool))):
        words = {
            "integer": "an integer",
            "boolean": "true or false",
            "string": "a text",
            "array": "a list",
            "object": "a table",
        }
        raise TypeError(f"`{name}` must be {words[kind or '']}, is {value!r}")
    if kind == "array" and "items" in about:
        return [_check_type(f"{name}[{i}]", item, about["items"]) for i, item in enumerate(value)]
    if "enum" in about and value not in about["enum"]:
        raise ValueError(f"`{name}` must be one of {about['enum']}, is {value!r}")
    return value


def make(cls: Any, keys: dict[str, Any]) -> Any:
    """An object of a plug-in's class, from the keys of a file."""
    about = cls._wbqp_fields
    for name in keys:
        if name not in about:
            raise TypeError(f"unknown key `{name}` (known: {', '.join(about)})")
    given = {name: _check_type(name, value, about[name]) for name, value in keys.items()}
    if dataclasses.is_dataclass(cls):
        return cls(**given)
    made = cls()
    for name, schema in about.items():
        if name in given:
            setattr(made, name, given[name])
        elif "default" not in schema:
            raise TypeError(f"key `{name}` is missing")
    return made


def change(made: Any, keys: dict[str, Any]) -> None:
    """Gives an object that runs other parameters."""
    about = type(made)._wbqp_fields
    for name, value in keys.items():
        object.__setattr__(made, name, _check_type(name, value, about[name]))


def _table(self: Any) -> dict[str, Any]:
    cls = type(self)
    if "_wbqp_tag" not in vars(cls):
        raise TypeError(
            f"{cls.__name__} is not registered, but a class that it is made from: decorate it with "
            f'@wbqp.{cls._wbqp_kind}("tag") as well'
        )
    about = cls._wbqp_fields
    values = {name: getattr(self, name, None) for name in about}
    for name, value in values.items():
        if value is None and about[name].get("default") is not None:
            raise TypeError(
                f"{cls.__name__}: `{name}` is None, which files have no word for: it would be its default, "
                f"{about[name]['default']!r}"
            )
    given = {key: value for key, value in values.items() if value is not None}
    return {"type": cls._wbqp_tag, **getattr(self, "_wbqp_entry", {}), **given}


def _decorator(kind: str, tag: str) -> Callable[[C], C]:
    def register(cls: C) -> C:
        needed = {"task": ("bind", "update"), "constraint": ("bind", "update"), "reference": ("sample",)}[kind]
        for method in needed:
            if not callable(getattr(cls, method, None)):
                raise TypeError(f"{cls.__name__} needs a method `{method}` to be a {kind}")
        about = _fields(cls)
        schema = {
            "type": "object",
            "description": inspect.cleandoc(cls.__doc__ or f"{cls.__name__}."),
            "properties": about,
            "required": [name for name, field in about.items() if "default" not in field],
            "additionalProperties": False,
        }
        plain = json.dumps(schema, default=lambda value: getattr(value, "tolist", lambda: None)())
        frame = inspect.currentframe()
        caller = frame.f_back if frame else None
        origin = f"{caller.f_code.co_filename}:{caller.f_lineno}" if caller else "Python"
        # A cell of a notebook that runs again defines the same class anew.
        _wbqp._register(kind, tag, cls, plain, origin, f"{cls.__module__}.{cls.__qualname__}")
        made: Any = cls
        made._wbqp_tag, made._wbqp_kind, made._wbqp_fields = tag, kind, about
        made._wbqp_table = _table
        return cls

    return register


def task(tag: str) -> Callable[[C], C]:
    """Registers a class as a task, which files name by ``type = tag`` and which is passed as an object as well.

    Its parameters are the fields of a dataclass, or annotations with defaults. ``bind(self, setup)`` resolves names and
    returns a `Layout`; ``update(self, tick, rows)`` writes the rows in every tick. Optional: ``activate(self)``, called
    when the entry is switched on. Each controller has an object of its own. A class with the same name in the same
    module takes the place of an earlier one for controllers that are made afterwards, as when a cell runs again.
    """
    return _decorator("task", tag)


def constraint(tag: str) -> Callable[[C], C]:
    """Registers a class as a constraint: as `task`; ``update`` writes ``rows.lower`` and ``rows.upper``."""

    def register(cls: C) -> C:
        bind: Any = getattr(cls, "bind", None)
        if callable(bind):

            def noting(self: Any, setup: Any) -> Any:
                layout = bind(self, setup)
                object.__setattr__(self, "_wbqp_equality", getattr(layout, "equality", False))
                return layout

            cls.bind = noting  # type: ignore[attr-defined]
        return _decorator("constraint", tag)(cls)

    return register


def reference(tag: str) -> Callable[[C], C]:
    """Registers a class as a reference.

    ``sample(self, time)`` returns the value, or ``(value, rate, acceleration)``. Optional: ``bind(self, space)``, with
    the number of values or ``"rotation"``, and ``start(self, time, value, rate)``, with what the task followed until
    then. Of a rotation the value is the quaternion w-x-y-z.
    """
    return _decorator("reference", tag)


def entry(plugin: Any, **keys: Any) -> dict[str, Any]:
    """A plug-in with keys of its entry: ``entry(LevelHead(frame="head"), name="head", weight=2.0)``."""
    return {**plugin._wbqp_table(), **keys}
