"""The Python on the book's pages is run, page by page, a page's blocks one after the other."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PAGES = [ROOT / "README.md", ROOT / "python/README.md", *sorted((ROOT / "docs").rglob("*.md"))]
# What follows from files that are not there, clusters and packages that the tests do not have, is compiled alone.
COMPILED = {"docs/campaigns.md"}
BLOCK = re.compile(r"^```python([^\n]*)\n(.*?)^```", re.MULTILINE | re.DOTALL)


def blocks(page: Path) -> list[tuple[str, str, int]]:
    """Marks, text and line of each block."""
    text = page.read_text(encoding="utf-8")
    return [(m.group(1), m.group(2), text[: m.start(2)].count("\n")) for m in BLOCK.finditer(text)]


WITH_PYTHON = [page for page in PAGES if blocks(page)]


def test_pages_are_found() -> None:
    assert len(WITH_PYTHON) >= 5


@pytest.mark.parametrize("page", WITH_PYTHON, ids=lambda page: str(page.relative_to(ROOT)))
def test_python_runs(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    name = page.relative_to(ROOT).as_posix()
    names: dict[str, object] = {"__name__": "book"}
    for marks, text, line in blocks(page):
        # Errors have the page's lines.
        code = compile("\n" * line + text, name, "exec")
        if "no_run" not in marks and name not in COMPILED:
            exec(code, names)  # noqa: S102
