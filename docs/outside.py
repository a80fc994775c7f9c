#!/usr/bin/env python3
"""Preprocessor of mdBook: links that leave the book, such as `../examples/robots/go2.toml`, lead to a copy inside.

The pages are read in two places: in the repository, where such a link is a path, and as a book, which knows nothing
outside of its folder. What is linked is written as an HTML page to `files/` beside the pages, which mdBook copies like
any picture; a folder becomes the list of its files. With `repository = "https://…"` in `[preprocessor.outside]` links
lead there instead, and nothing is copied.
"""

import html
import json
import re
import subprocess
import sys
from pathlib import Path

DOCS = Path(__file__).resolve().parent
ROOT = DOCS.parent
COPIES = DOCS / "files"
LINK = re.compile(r"\]\(((?:\.\./)+[^)#\s]*)(#[^)\s]*)?\)")
PAGE = """<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{title}</title>
<style>
body {{ margin: 0 auto; max-width: 60rem; padding: 1rem; font-family: sans-serif }}
pre {{ overflow-x: auto; padding: 1rem; background: #f6f7f8; font-size: 0.85rem }}
</style>
</head>
<body>
<h1><code>{title}</code></h1>
{body}
</body>
</html>
"""


def tracked(folder):
    """Files of the repository below a folder, relative to it: what is built there is none of them."""
    command = ["git", "-C", str(folder), "ls-files", "--cached", "--others", "--exclude-standard", "."]
    listed = subprocess.run(command, capture_output=True, text=True)
    if listed.returncode == 0:
        return sorted(line for line in listed.stdout.splitlines() if (folder / line).is_file())
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file())


def write(path, text):
    """Only what has changed, so that `mdbook serve`, which watches the folder, comes to rest."""
    if path.is_file() and path.read_text() == text:
        return
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)


def copy(path):
    """Writes the page of a file or folder; its place below `files/`."""
    name = path.relative_to(ROOT)
    # mdBook takes `.md` in a link for a page of its own.
    place = COPIES / f"{str(name).replace('.md', '-md')}.html"
    if path.is_dir():
        up = "../" * len(name.parent.parts)
        items = [f'<li><a href="{up}{html.escape(str(copy(path / file)))}">{file}</a></li>' for file in tracked(path)]
        body = "<ul>\n" + "\n".join(items) + "\n</ul>"
    else:
        body = f"<pre>{html.escape(path.read_text(errors='replace'))}</pre>"
    write(place, PAGE.format(title=html.escape(str(name)), body=body))
    return place.relative_to(COPIES)


def turn(chapter, repository):
    """Rewrites the links of one page."""
    folder = (DOCS / chapter["path"]).parent

    def target(match):
        path, anchor = match.groups()
        path, anchor = (folder / path).resolve(), anchor or ""
        if path.is_relative_to(DOCS):
            return match.group(0)
        if not path.exists() or not path.is_relative_to(ROOT):
            sys.exit(f"docs/{chapter['path']}: there is no {match.group(1)}")
        if repository:
            kind = "tree" if path.is_dir() else "blob"
            return f"]({repository}/{kind}/main/{path.relative_to(ROOT)}{anchor})"
        up = "../" * len(Path(chapter["path"]).parent.parts)
        return f"]({up}files/{copy(path)})"

    chapter["content"] = LINK.sub(target, chapter["content"])


def walk(items, repository):
    for item in items:
        chapter = item.get("Chapter") if isinstance(item, dict) else None
        if chapter is not None:
            if chapter["path"] is not None:
                turn(chapter, repository)
            walk(chapter["sub_items"], repository)


def main():
    if sys.argv[1:2] == ["supports"]:
        sys.exit(0 if sys.argv[2:] == ["html"] else 1)
    context, book = json.load(sys.stdin)
    own = context["config"].get("preprocessor", {}).get("outside", {})
    walk(book.get("items", book.get("sections")), own.get("repository"))
    json.dump(book, sys.stdout)


if __name__ == "__main__":
    main()
