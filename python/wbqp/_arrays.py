"""Arrays whose first axis has names."""

from __future__ import annotations

from typing import Any

import numpy as np


class NamedArray(np.ndarray):
    """An array that is also indexed by name along its first axis: ``command.effort["rotor_1"]``.

    What is computed from it is an ordinary array; copies have its names.
    """

    names: tuple[str, ...] | None

    def __new__(cls, array: np.ndarray, names: tuple[str, ...]) -> NamedArray:
        view = array.view(cls)
        view.names = names
        return view

    def __array_finalize__(self, array: Any) -> None:
        self.names = None

    def __array_wrap__(self, array: np.ndarray, context: Any = None, return_scalar: bool = False) -> Any:
        if array is self:
            return self
        return array[()] if return_scalar else np.asarray(array)

    def copy(self, order: Any = "C") -> Any:
        array = np.array(self, order=order)
        return array if self.names is None else NamedArray(array, self.names)

    def __copy__(self) -> Any:
        return self.copy()

    def __deepcopy__(self, memo: Any) -> Any:
        return self.copy()

    def __reduce__(self) -> Any:
        array = np.array(self)
        return array.__reduce__() if self.names is None else (NamedArray, (array, self.names))

    def _at(self, key: str) -> int:
        names = self.names
        if names is None:
            raise KeyError(f"{key!r}: this part of an array has no names; index the array that it is of")
        try:
            return names.index(key)
        except ValueError:
            raise KeyError(f"{key!r} is none of {', '.join(names)}") from None

    def __getitem__(self, key: Any) -> Any:
        if isinstance(key, str):
            key = self._at(key)
        item = super().__getitem__(key)
        return item.view(np.ndarray) if isinstance(item, NamedArray) else item

    def __setitem__(self, key: Any, value: Any) -> None:
        if isinstance(key, str):
            key = self._at(key)
        super().__setitem__(key, value)
