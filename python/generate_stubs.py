"""Writes the stubs of the modules that are made from the registry: wbqp/tasks.pyi and the like.

    python generate_stubs.py           writes them
    python generate_stubs.py --check   says which are not what the installed package would give, and fails
"""

from __future__ import annotations

import sys
import textwrap
from pathlib import Path

# The installed package, not its sources beside this file, which have no extension module.
sys.path = [place for place in sys.path if Path(place or ".").resolve() != Path(__file__).parent.resolve()]

from wbqp import _plugins  # noqa: E402

HEAD = '''"""Made by generate_stubs.py from the registry's JSON Schema: do not edit."""

from collections.abc import Sequence
from typing import Any, Literal

from wbqp._plugins import Plugin
'''


def _wrapped(line: str) -> str:
    """A line of documentation as lines that the stub has room for."""
    # What is a parameter's own line goes on farther to the right than its description.
    indent = " " * (len(line) - len(line.lstrip()) + (8 if " : " in line else 0))
    wide = textwrap.TextWrapper(116, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False)
    return "\n".join(wide.wrap(line)) or line


def _class(name: str, cls: type[_plugins.Plugin]) -> str:
    schema = cls._schema
    lines = [f"class {name}(Plugin):"]
    document = (cls.__doc__ or "").replace("\\", "\\\\")
    first, *rest = f'"""{document}'.split("\n\n")
    document = "\n\n".join([first.replace("\n", " "), *rest])
    document = "\n".join(map(_wrapped, document.split("\n")))
    lines.append(textwrap.indent(f'{document}\n"""', "    ", lambda line: line.strip() != ""))
    lines.append("    def __init__(")
    lines.append("        self,")
    ordered = _plugins._ordered(schema)
    if ordered:
        lines.append("        *,")
    for key, about in ordered:
        kind = _plugins.annotation(about)
        default = "" if key in schema.get("required", []) else " = ..."
        optional = " | None" if default and kind != "Any" else ""
        lines.append(f"        {_plugins.python_name(key)}: {kind}{optional}{default},")
    lines.append("    ) -> None: ...")
    return "\n".join(lines)


def stubs() -> dict[str, str]:
    """The text of each stub, by file."""
    made = {}
    for module in _plugins._KINDS:
        classes = _plugins.classes(module)
        parts = [HEAD, *(f"\n{_class(name, cls)}\n" for name, cls in classes.items())]
        names = "".join(f'    "{name}",\n' for name in sorted(classes))
        parts.append(f"\n__all__ = [\n{names}]\n")
        made[f"{module}.pyi"] = "".join(parts)
    made["_contact.pyi"] = HEAD + f"\n{_class('Contact', _plugins.contact())}\n"
    return made


def main() -> int:
    folder = Path(__file__).parent / "wbqp"
    stale = []
    for name, text in stubs().items():
        path = folder / name
        if path.exists() and path.read_text(encoding="utf-8") == text:
            continue
        stale.append(name)
        if "--check" not in sys.argv:
            path.write_text(text, encoding="utf-8")
    if stale and "--check" in sys.argv:
        print(f"not current: {', '.join(stale)}; run python/generate_stubs.py with this package installed")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
