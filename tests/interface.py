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
DOC = ROOT / "target/doc/wbqp"
KINDS = ["struct", "enum", "trait"]
HEAD = """# The interface

All public types of the crate `wbqp`, module by module, a sentence each; a type that is in several places stands in the
first. Written by `python3 tests/interface.py` from the documentation of the code. What a program needs first is in
[getting started](../README.md), what an author of plug-ins needs in [write your own task](write-your-own-task.md):
`use wbqp::prelude::*;`.
"""


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


def modules():
    """The crate's modules in the order of their pages, the crate itself last."""
    crate = (DOC / "index.html").read_text()
    names = [name for name, kind, _, _ in items(crate) if kind == "mod"]
    return [(name, (DOC / name / "index.html").read_text()) for name in names] + [("", crate)]


def main() -> None:
    command = ["cargo", "doc", "--no-deps", "-p", "wbqp", "-p", "wbqp-qp", "-p", "wbqp-clarabel", "--quiet"]
    subprocess.run(command, cwd=ROOT, check=True)
    seen = set()
    count = 0
    page = [HEAD]
    for module, source in modules():
        if module == "prelude":
            continue
        lines = []
        for name, kind, target, sentence in items(source):
            place = f"{module}/{target}"
            if kind not in KINDS or place in seen or target.startswith("http"):
                continue
            seen.add(place)
            count += 1
            lines.append(f"| `{name}` | {kind} | {sentence} |")
        if lines:
            title = f"`wbqp::{module}`" if module else "`wbqp`"
            page += [f"\n## {title}\n", "| type | | |", "|---|---|---|", *lines]
    if "--count" in sys.argv:
        print(count)
        return
    (ROOT / "docs/interface.md").write_text("\n".join(page) + f"\n\n{count} types.\n")
    print(f"docs/interface.md: {count} types")


main()
