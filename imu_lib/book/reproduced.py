"""The page of what is reproduced: each table, figure and equation of the papers, where it is met,
and how far ours is from what is printed.

Made from book/reproduced.toml and from what the chapters' cells store; nothing in it is typed by
hand.
"""

import re
import tomllib
from pathlib import Path

import nbformat

from imu_lib.book import chapters

MIME = "application/vnd.imu-lib.comparison+json"  # as `imu_lib.tables.compared` stores it
NAME = r"((?:fig|tab|eq)-(?:2008|2011|2013)-[\w-]+)"
TARGETS = (rf"^\({NAME}\)=", rf"\$\$\s*\({NAME}\)", rf":(?:label|name): {NAME}")
HEAD = """# Reproduction of the papers: what agrees, and where is it?

Each table, figure and numbered equation of the three papers that the book meets. A figure is reproduced on a twin of
the paper's sensor, with the paper's published values beside it where it prints any: the papers' own recordings are not
public. Where a table prints values, the last column says how many of ours lie within ten per cent, the median of ours
over theirs, and the value that is furthest off; these numbers are stored by the chapters as they are executed. Where a
number or a formula of a paper does not hold, {doc}`../nbs/errata` shows why. What is not reproduced is listed too, with
the reason.
"""


def items(root: Path) -> list[dict]:
    return tomllib.loads((root / "book/reproduced.toml").read_text(encoding="utf-8"))["paper"]


def targets(root: Path) -> dict[str, list[str]]:
    """Label of a table, figure or equation of a paper -> the chapters that define it."""
    found = {}
    for chapter in chapters.chapters(root):
        for cell in nbformat.read(chapter.path, as_version=4).cells:
            if cell.cell_type == "markdown":
                for pattern in TARGETS:
                    for name in re.findall(pattern, cell.source, re.MULTILINE):
                        found.setdefault(name, []).append(chapter.slug)
    return found


def comparisons(root: Path) -> dict[str, dict]:
    """Item, as "2013 Table 4" -> what its chapter stored."""
    found = {}
    for chapter in chapters.chapters(root):
        for cell in nbformat.read(chapter.path, as_version=4).cells:
            for output in cell.get("outputs", []):
                stored = output.get("data", {}).get(MIME)
                if stored:
                    found[stored["item"]] = stored
    return found


def page(root: Path) -> str:
    """The text of the page."""
    where, stored = targets(root), comparisons(root)
    titles = {c.slug: c.title.partition(":")[0] for c in chapters.chapters(root)}
    lines = [HEAD]
    for paper in items(root):
        year = paper["year"]
        lines += [f"## The {year} paper", "", paper["intro"], ""]
        lines += ["| | what | where | ours against theirs |", "|---|---|---|---|"]
        for item in paper["item"]:
            links = "; ".join(
                f"{{ref}}`{titles[where[label][0]]} <{label}>`" for label in item.get("labels", ())
            )
            result = verdict(stored.get(f"{year} {item['name']}"), item)
            links = links or f"not reproduced: {item['reason']}"
            lines.append(f"| {item['name']} | {item['what']} | {links} | {result} |")
        lines += ["", "Equations, by chapter and with the numbers of the paper:", ""]
        lines += equations(year, where, titles) + [""]
    return "\n".join(lines)


def verdict(found: dict | None, item: dict) -> str:
    """The last column: numbers where there are any."""
    if found is None:
        drawn = item["name"].startswith("Fig") and item.get("labels")
        return (
            "drawn; the paper prints no values"
            if drawn
            else "recomputed"
            if item.get("labels")
            else ""
        )
    words = f"{found['within']} of {found['values']} within 10 %"
    if found["median_ratio"] is not None:
        words += f", median ratio {found['median_ratio']:g}"
    if found["furthest"] and found["within"] < found["values"]:
        name, ours, printed = found["furthest"]
        words += f"; furthest `{name}`: {ours:g} against {printed:g}"
    return f"{words}. {found['remark']}" if found["remark"] else words


def equations(year: int, where: dict, titles: dict) -> list[str]:
    """A line for each chapter that has equations of this paper, with their numbers."""
    by = {}
    for label, slugs in where.items():
        found = re.fullmatch(rf"eq-{year}-(\d+)(?:-\w+)?", label)
        if found:
            by.setdefault(slugs[0], {})[int(found[1])] = label
    return [
        f"- {{doc}}`../nbs/{slug}`: "
        + ", ".join(f"{{ref}}`Eq. {n} <{label}>`" for n, label in sorted(numbers.items()))
        for slug, numbers in by.items()
        if slug in titles
    ]


def write(root: Path) -> None:
    (root / "book/reproduced.md").write_text(page(root), encoding="utf-8")
