"""What is wrong with a configuration."""

from __future__ import annotations

from typing import NamedTuple


class Mistake(NamedTuple):
    """One thing that is wrong. File, line and column are ``None`` where the configuration is no file."""

    file: str | None
    line: int | None
    column: int | None
    subject: str
    message: str

    def __str__(self) -> str:
        place = ":".join(str(part) for part in (self.file, self.line, self.column) if part is not None)
        return ": ".join(part for part in (place, self.subject, self.message) if part)


class ConfigError(ValueError):
    """A configuration was refused: ``errors`` has everything that is wrong, ``str()`` one line for each."""

    errors: list[Mistake]

    def __init__(self, errors: list[Mistake]) -> None:
        self.errors = list(errors)
        super().__init__("\n".join(map(str, self.errors)))

    def __reduce__(self) -> tuple[type[ConfigError], tuple[list[Mistake]]]:
        return type(self), (self.errors,)
