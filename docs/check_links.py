#!/usr/bin/env python3
"""Follows every link of the built book, and of the READMEs, that does not leave this machine.

    python3 docs/check_links.py docs/book

A link must lead to a file that is there, and what follows `#` must be the id of an element of it. Pictures have to be
there as well. Addresses of the web are only counted: nothing is fetched.
"""

import re
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

ROOT = Path(__file__).resolve().parent.parent
READMES = ["README.md", "python/README.md", "framework/qp/README.md"]
MARKDOWN_LINK = re.compile(r"\]\(([^)\s]+)\)")


class Page(HTMLParser):
    """Ids and links of a page."""

    def __init__(self, text):
        super().__init__()
        self.ids, self.links = set(), []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        for key, value in attributes:
            if key in ("id", "name") and value:
                self.ids.add(value)
            elif key in ("href", "src") and value:
                self.links.append(value)


def of_the_web(link):
    return bool(urlsplit(link).scheme or link.startswith("//"))


def main():
    built = Path(sys.argv[1]).resolve()
    # One long page of all others, whose links are theirs; and the page for what is not found.
    files = [path for path in built.rglob("*.html") if path.name not in ("print.html", "404.html")]
    pages = {path: Page(path.read_text()) for path in files}
    wrong, web, followed = [], 0, 0
    for path, page in pages.items():
        for link in page.links:
            if of_the_web(link):
                web += 1
                continue
            parts = urlsplit(link)
            target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            followed += 1
            place = f"{path.relative_to(built)}: {link}"
            if target.name == "print.html":
                continue
            if not target.is_file():
                wrong.append(f"{place}: there is no such file")
            elif parts.fragment and unquote(parts.fragment) not in getattr(pages.get(target), "ids", ()):
                wrong.append(f"{place}: there is no such heading")
    for name in READMES:
        readme = ROOT / name
        if not readme.is_file():
            continue
        for link in MARKDOWN_LINK.findall(readme.read_text()):
            if of_the_web(link):
                web += 1
                continue
            path, _, _ = link.partition("#")
            followed += 1
            if path and not (readme.parent / path).exists():
                wrong.append(f"{name}: {link}: there is no such file")
    print(f"{len(pages)} pages, {followed} links followed, {web} of the web not fetched")
    for line in sorted(set(wrong)):
        print(line, file=sys.stderr)
    sys.exit(1 if wrong or not followed else 0)


if __name__ == "__main__":
    main()
