#!/usr/bin/env python3
"""Writes docs/interface.md: every public type of `wbqp` with its sentence, from the pages of `cargo doc`.

    python3 tests/interface.py            writes the page
    python3 tests/interface.py --count    prints the number of types alone
"""

import html
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
DOC = ROOT / "target/doc"
KINDS = ["struct", "enum", "trait"]
HEAD = """# The interface

All public types, a sentence each: of the crate `wbqp` module by module; of `wbqp-replay`, which a program adds that
runs recorded ticks again; and of the three crates below `wbqp`, which it has as its modules `robot`, `dynamics` (with
`actuator`, `model`, `spatial` and `state`) and `qp`. A type that is in several places stands in the first. Left out is
what only the code of the attributes and the crate `wbqp-testing` name. Written by `python3 tests/interface.py` from the
documentation of the code. What a program needs first is in the [readme](../README.md), what an author of plug-ins
needs in [write your own task](write-your-own-task.md): `use wbqp::prelude::*;`.
"""
CRATES = ["wbqp", "wbqp-replay", "wbqp-robot-model", "wbqp-dynamics", "wbqp-qp"]


def text(markup: str) -> str:
    """Words of a piece of HTML, code in backticks."""
    markup = re.sub(r"<code>(.*?)</code>", r"`\1`", markup)
    return html.unescape(re.sub(r"<[^>]+>", "", markup)).strip()


def items(page: str):
    """Name, kind, target and sentence of each item of a module's page."""
    pattern = r'<dt>(.*?)</dt>(?:<dd>(.*?)</dd>)?'
    for term, sentence in re.findall(pattern, page, re.S):
        link = re.search(r'<a class="(\w+)" href="([^"]+)"[^>]*>(.*?)</a>', term)
        if link:
            kind, target, name = link.groups()
            yield text(name), kind, target, " ".join(text(sentence or "").split())


def modules(crate: str):
    """The crate's modules in the order of their pages, the crate itself first."""
    folder = DOC / crate.replace("-", "_")
    page = (folder / "index.html").read_text()
    names = [name for name, kind, _, _ in items(page) if kind == "mod"]
    return [("", page)] + [(name, (folder / name / "index.html").read_text()) for name in names]


def main() -> None:
    command = ["cargo", "doc", "--no-deps", "--quiet"]
    command += [part for crate in [*CRATES, "wbqp-clarabel"] for part in ("-p", crate)]
    subprocess.run(command, cwd=ROOT, check=True)
    page = [HEAD]
    counts = []
    for crate in CRATES:
        seen = set()
        sections = []
        for module, source in modules(crate):
            if module == "prelude":
                continue
            lines = []
            for name, kind, target, sentence in items(source):
                # What another of the crates has stands there.
                place = f"{module}/{target}" if module else target
                if kind not in KINDS or place in seen or target.startswith(("http", "../")):
                    continue
                seen.add(place)
                lines.append(f"| `{name}` | {kind} | {sentence} |")
            if lines:
                root = crate.replace("-", "_")
                title = f"`{root}::{module}`" if module else f"`{root}`"
                sections += [f"\n### {title}\n", "| type | | |", "|---|---|---|", *lines]
        counts.append((crate, len(seen)))
        page += [f"\n## {crate}: {len(seen)} types", *sections]
    if "--count" in sys.argv:
        print(", ".join(f"{crate} {count}" for crate, count in counts))
        return
    (ROOT / "docs/interface.md").write_text("\n".join(page) + "\n")
    print(f"docs/interface.md: {counts}")


main()
