#!/usr/bin/env python3
"""Whether every number of docs/evidence.md stands where the page says, and every one of README's tables is measured.

    python3 tests/release/evidence.py            looks every number up
    python3 tests/release/evidence.py --dates    writes the page's last table again: when each was measured

A section of the page ends with a comment, `<!-- stands in`, whose lines are `FILE: words of the file`. Of every table
row, list item and paragraph of the section each number has to be in such words of a file that the row itself names, as
a link or in backticks; the words have to be in the file; and none may be there for nothing. Files that the page names
have to exist. Line ends, and spaces within long numbers, do not matter.
"""

import re
import subprocess
import sys
from datetime import datetime, timezone
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
PAGE = ROOT / "docs/evidence.md"
COMMENT = re.compile(r"<!-- stands in\n(.*?)\n-->", re.S)
# Pages whose numbers come from runs that CI does not repeat, so they have a date.
MEASURED = {
    f"docs/{name}.md"
    for name in ("campaigns", "degradation", "mujoco", "performance", "replication", "robustness", "web-page")
}
DATES = ("<!-- dates -->", "<!-- end of dates -->")
NUMBER = re.compile(r"(?<![\w./^-])\d+(?:\.\d+)*(?:e-?\d+)?(?!\w)")


def numbers(text: str) -> set[str]:
    """The numbers in a text; those in names, as `B4`, are none."""
    joined = re.sub(r"(?<=\d)[_ \u00a0](?=\d{3}(?!\d))", "", text)
    return set(NUMBER.findall(joined))


def on_one_line(text: str) -> str:
    return re.sub(r"\s*\n\s*(?://[/!] ?|> ?)?", " ", text)


def named_files(unit: str) -> set[str]:
    """Files of the repository that a piece of the page names, as paths from its root."""
    found = set()
    for target in re.findall(r"\]\(([^)#]*)[^)]*\)", unit):
        if target and "://" not in target:
            found.add(str((PAGE.parent / target).resolve().relative_to(ROOT)))
    for code in re.findall(r"`([^`]+)`", unit):
        for word in code.split():
            if "/" in word and re.fullmatch(r"[\w./-]+", word) and re.search(r"\.\w+$|^\.ci/", word):
                found.add(word)
    return found


def visible_numbers(unit: str) -> set[str]:
    words = re.sub(r"\]\([^)]*\)", "]", unit)
    return numbers(re.sub(r"`[^`]*`", "", words))


def units(text: str) -> list[str]:
    """Table rows, list items and paragraphs."""
    parts = []
    for block in re.split(r"\n\s*\n", text):
        block = block.strip("\n")
        if block.startswith("|"):
            parts += block.split("\n")[2:]
        elif block.startswith("* "):
            parts += re.split(r"\n(?=\* )", block)
        elif not block.startswith("#"):
            parts.append(block)
    return [part for part in parts if part.strip()]


def faults_of_section(section: str, texts: dict[str, str]) -> list[str]:
    faults, quotes = [], []
    for comment in COMMENT.findall(section):
        for line in comment.splitlines():
            file, _, words = line.partition(": ")
            quotes.append((file, words))
            if file not in texts:
                path = ROOT / file
                texts[file] = on_one_line(path.read_text(encoding="utf-8")) if path.is_file() else ""
            if words not in texts[file]:
                faults.append(f"{file} does not say: {words}")
    used = set()
    for unit in units(COMMENT.sub("", section)):
        files = named_files(unit)
        faults += [f"there is no {file}" for file in sorted(files) if not (ROOT / file).exists()]
        for number in sorted(visible_numbers(unit)):
            places = [quote for quote in quotes if quote[0] in files and number in numbers(quote[1])]
            used.update(places)
            if not places:
                faults.append(f"{number} stands in none of the quoted words of the files named in: {unit[:100]}")
    faults += [f"nothing on the page needs: {file}: {words}" for file, words in quotes if (file, words) not in used]
    return faults


def faults_of_readme(readme: str, measured: str) -> list[str]:
    """Numbers of README's tables that stand in no row, of the page with the measurements, of their column's library."""

    def cells(line: str) -> list[str]:
        return [cell.strip() for cell in line.strip().strip("|").split("|")]

    rows = [(cells(line)[0].lower(), numbers(line)) for line in measured.splitlines() if line.startswith("|")]
    told = [cells(line) for line in readme.splitlines() if line.startswith("|")]
    faults = []
    for line in told[2:]:
        for library, cell in zip(told[0][1:], line[1:]):
            names = library.lower().split(", ")
            of_library = (found for first, found in rows if any(first.startswith(name) for name in names))
            unknown = visible_numbers(cell) - set().union(*of_library)
            faults += [
                f"README.md: {number} of {library} is in no row of that in docs/performance.md: {line[0]}"
                for number in sorted(unknown)
            ]
    return faults


def heading_above(lines: list[str], index: int) -> str:
    above = [line for line in lines[: index + 1] if re.match(r"#+ ", line)]
    return above[-1].lstrip("# ") if above else ""


def last_written(file: str, words: str) -> tuple[str, str, str] | None:
    """Section, date and commit of the line of a measured page in which the words begin."""
    lines = (ROOT / file).read_text(encoding="utf-8").splitlines()
    # The words may go on for some lines.
    starts = [
        i
        for i, line in enumerate(lines)
        if words[:25] in line and words[:80] in on_one_line("\n".join(lines[i : i + 4]))
    ]
    if not starts:
        return None
    blame = ["git", "blame", "--porcelain", f"-L{starts[0] + 1},{starts[0] + 1}", "--", file]
    told = subprocess.run(blame, cwd=ROOT, check=True, capture_output=True, text=True).stdout
    commit = told.split()[0]
    seconds = re.search(r"^committer-time (\d+)", told, re.M)
    if seconds is None or set(commit) == {"0"}:
        sys.exit(f"{file}: commit it first, line {starts[0] + 1} has no date yet")
    date = datetime.fromtimestamp(int(seconds[1]), timezone.utc).date().isoformat()
    return heading_above(lines, starts[0]), date, commit[:10]


def table_of_dates(page: str) -> str:
    """One row for each section of a measured page that the page of evidence quotes, newest line first."""
    rows: dict[tuple[str, str], set[tuple[str, str]]] = {}
    for comment in COMMENT.findall(page):
        for line in comment.splitlines():
            file, _, words = line.partition(": ")
            found = last_written(file, words) if file in MEASURED else None
            if found:
                rows.setdefault((file, found[0]), set()).add(found[1:])
    told = ["| page | section | its quoted lines are of | revision |", "|---|---|---|---|"]
    for (file, section), seen in sorted(rows.items()):
        date, commit = max(seen)
        name = Path(file).name
        told.append(f"| [{name}]({name}) | {section} | {date} | `{commit}` |")
    return "\n".join(told)


def write_dates() -> None:
    page = PAGE.read_text(encoding="utf-8")
    before, start, rest = page.partition(DATES[0])
    _, end, after = rest.partition(DATES[1])
    if not end:
        sys.exit(f"{PAGE}: there is no {DATES[0]} … {DATES[1]}")
    PAGE.write_text(f"{before}{start}\n{table_of_dates(page)}\n{end}{after}", encoding="utf-8")


def check_the_checker() -> None:
    """On a page with mistakes it has to find them."""
    row = "| a | b |\n|---|---|\n| %s | `tests/release/evidence.py` |\n"
    place = "tests/release/evidence.py"
    assert faults_of_section(row % "12", {})
    quoted = f"{row}\n<!-- stands in\n{place}: at 12.5 of 20 000\n-->"
    texts = {place: "it is at 12.5 of 20 000 today"}
    assert not faults_of_section(quoted % "12.5, 20000", texts)
    assert len(faults_of_section(quoted % "12.5, 13", texts)) == 1
    assert len(faults_of_section(quoted % "12.5", {place: "it is at 12.6 of 20 000"})) == 1
    assert len(faults_of_section(quoted % "B4", texts)) == 1
    peers = "| | wbqp | TSID |\n|---|---|---|\n| tick | 9.5 µs | 46.1 µs |"
    assert not faults_of_readme(peers, "| wbqp | 9.5 | 12 |\n| TSID | 3 | 46.1 |")
    assert len(faults_of_readme(peers, "| wbqp | 46.1 | 12 |\n| TSID | 3 | 9.5 |")) == 2


def main() -> None:
    if sys.argv[1:] == ["--dates"]:
        write_dates()
        return
    check_the_checker()
    page = PAGE.read_text(encoding="utf-8")
    texts: dict[str, str] = {}
    # Dates and revisions are git's, not measured.
    page = re.sub(f"{DATES[0]}.*?{DATES[1]}", "", page, flags=re.S)
    sections = re.split(r"\n(?=## )", page)
    faults = [fault for section in sections for fault in faults_of_section(section, texts)]
    faults += faults_of_readme((ROOT / "README.md").read_text(), (ROOT / "docs/performance.md").read_text())
    if faults:
        sys.exit("docs/evidence.md:\n" + "\n".join(faults))
    count = sum(len(visible_numbers(unit)) for section in sections for unit in units(COMMENT.sub("", section)))
    print(f"docs/evidence.md: {count} numbers in {len(texts)} files, each where the page says")


if __name__ == "__main__":
    main()
