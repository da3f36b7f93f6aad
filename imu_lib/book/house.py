"""The picture of the house: the rooms of the package by layer, and who imports whom, drawn from the
table on the contributor's page and from the imports themselves.
"""

import ast
import html
import re
from pathlib import Path

from imu_lib.book.chapters import PACKAGE

MARK = "<!-- house -->"
WIDTH, ROW, HEIGHT, CHARACTER = 1120, 92, 30, 7.4  # of the picture, a layer, a box, a letter


def layers(text: str) -> dict[str, int]:
    """room -> layer, of the table between the marks of the contributor's page."""
    table = text.split("<!-- layers -->")[1]
    rows = re.findall(r"^\| (\d+) \| ([^|]+) \|", table, re.MULTILINE)
    return {room: int(layer) for layer, names in rows for room in re.findall(r"`(\w+)`", names)}


def imports(package: Path = PACKAGE) -> dict[str, set[str]]:
    """room -> the rooms that its files import, those inside functions included."""
    found: dict[str, set[str]] = {}
    for path in sorted(package.rglob("*.py")):
        parts = path.relative_to(package).with_suffix("").parts
        room = parts[0]
        if room.startswith("_"):
            continue
        own = found.setdefault(room, set())
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            own |= {name.split(".")[0] for name in _named(node, parts)}
    rooms = set(found)
    return {room: (seen & rooms) - {room} for room, seen in found.items()}


def _named(node, parts):
    """What follows `imu_lib.` in an import, of a file at `parts`."""
    if isinstance(node, ast.Import):
        return [a.name.partition(".")[2] for a in node.names if a.name.startswith("imu_lib.")]
    if not isinstance(node, ast.ImportFrom):
        return []
    if node.level:
        base = parts[: len(parts) - node.level]
        if base:  # within the room
            return []
        return [node.module] if node.module else [a.name for a in node.names]
    if node.module == "imu_lib":
        return [a.name for a in node.names]
    return [node.module.partition(".")[2]] if (node.module or "").startswith("imu_lib.") else []


def needed(edges: dict[str, set[str]]) -> dict[str, set[str]]:
    """The imports that no chain of others says already."""
    reach: dict[str, set[str]] = {}

    def below(room, seen=()):
        if room not in reach and room not in seen:
            reach[room] = set().union(
                *({other} | below(other, (*seen, room)) for other in edges.get(room, ()))
            )
        return reach.get(room, set())

    return {
        room: {o for o in others if not any(o in below(p) for p in others if p != o)}
        for room, others in edges.items()
    }


def drawing(table: dict[str, int], edges: dict[str, set[str]]) -> str:
    """SVG: a row for each layer, the highest on top, and a line for each import."""
    top = max(table.values())
    boxes = {}
    for layer in range(top + 1):
        rooms = [room for room, at in table.items() if at == layer]
        widths = [CHARACTER * len(room) + 16 for room in rooms]
        gap = (WIDTH - 40 - sum(widths)) / (len(rooms) + 1)
        x = 40 + gap
        for room, width in zip(rooms, widths, strict=True):
            boxes[room] = (x, 14 + (top - layer) * ROW, width)
            x += width + gap
    height = (top + 1) * ROW
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height}" role="img" '
        'aria-label="Rooms of the package by layer, with the imports between them" class="house">',
        f'<rect width="{WIDTH}" height="{height}" fill="#ffffff"/>',
    ]
    for layer in range(top + 1):
        parts.append(f'<text x="8" y="{34 + (top - layer) * ROW}" class="layer">{layer}</text>')
    for room, others in sorted(needed(edges).items()):
        for other in sorted(others):
            if table.get(other, top) < table.get(room, -1):  # the exception goes upwards
                parts.append(_line(boxes[room], boxes[other]))
    for room, (x, y, width) in boxes.items():
        said = ", ".join(sorted(edges.get(room, ()))) or "nothing of the package"
        parts.append(
            f"<g><title>{html.escape(f'{room} imports {said}')}</title>"
            f'<rect x="{x:.1f}" y="{y}" width="{width:.1f}" height="{HEIGHT}" rx="5"/>'
            f'<text x="{x + width / 2:.1f}" y="{y + 20}" text-anchor="middle">{room}</text></g>'
        )
    return "\n".join([*parts, "</svg>"])


def _line(start, end) -> str:
    x0, y0 = start[0] + start[2] / 2, start[1] + HEIGHT
    x1, y1 = end[0] + end[2] / 2, end[1]
    bend = (y1 - y0) / 2
    return (
        f'<path d="M{x0:.1f} {y0}C{x0:.1f} {y0 + bend:.1f} {x1:.1f} {y1 - bend:.1f} {x1:.1f} '
        f'{y1}"/>'
    )


def write(root: Path) -> None:
    """Put the picture into the contributor's page, where it has the mark."""
    path = root / "book/contributing.md"
    text = path.read_text(encoding="utf-8")
    if MARK not in text:
        return
    edges = imports()
    count = sum(map(len, edges.values()))
    shown = sum(map(len, needed(edges).values()))
    caption = (
        f"The house, drawn from its imports when these pages were built: {len(edges)} rooms, "
        f"{count} imports, of which the {shown} that no chain of others says already are lines. A "
        "room says what it imports when the pointer rests on it."
    )
    drawn = drawing(layers(text), edges)
    picture = f'<figure class="house">{drawn}<figcaption>{caption}</figcaption></figure>'
    text = text.replace(MARK, f"```{{raw}} html\n{picture}\n```")
    path.write_text(text, encoding="utf-8")
