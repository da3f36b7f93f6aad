"""Sentences with a tag and, mostly, a checksum: `$VNIMU,...*5B`."""

from __future__ import annotations

import re
from collections import Counter

from imu_lib.readers.lines import NUMBER, PREFIX, Table, as_table, share, without_stamp

_SENTENCE = re.compile(r"^\s*([$!@#]?[A-Za-z][A-Za-z0-9_]{1,11})\s*[,;:\t ]\s*[+-]?[\d.]")


#: Fields after the tag of sentences whose makers fix them (VectorNav's ASCII output).
SENTENCES = {
    "VNIMU": "mag_x mag_y mag_z accel_x[m/s^2] accel_y[m/s^2] accel_z[m/s^2] gyro_x[rad/s] "
    "gyro_y[rad/s] gyro_z[rad/s] temperature[degC] pressure",
    "VNYMR": "yaw pitch roll mag_x mag_y mag_z accel_x[m/s^2] accel_y[m/s^2] accel_z[m/s^2] "
    "gyro_x[rad/s] gyro_y[rad/s] gyro_z[rad/s]",
    "VNQMR": "quat_x quat_y quat_z quat_w mag_x mag_y mag_z accel_x[m/s^2] accel_y[m/s^2] "
    "accel_z[m/s^2] gyro_x[rad/s] gyro_y[rad/s] gyro_z[rad/s]",
    "VNMAR": "mag_x mag_y mag_z accel_x[m/s^2] accel_y[m/s^2] accel_z[m/s^2] gyro_x[rad/s] "
    "gyro_y[rad/s] gyro_z[rad/s]",
    "VNGYR": "gyro_x[rad/s] gyro_y[rad/s] gyro_z[rad/s]",
    "VNACC": "accel_x[m/s^2] accel_y[m/s^2] accel_z[m/s^2]",
}


def is_sentences(lines) -> bool:
    def sentence(line):
        m = _SENTENCE.match(without_stamp(line)[1])
        return bool(m) and (m[1][0] in "$!@" or line.rstrip()[-3:-2] == "*")

    return share(lines, sentence) > 0.6


def sentences(lines) -> Table | None:
    """Sentences of one tag; others (positions, remarks) are left out, and so are damaged ones."""
    found: dict[str, list[tuple[list[str], int]]] = {}
    damaged = 0
    # a sum that hardly ever fits is another kind of sum
    starred = [line.strip().partition("*") for line in lines[:400] if "*" in line]
    checked = not starred or sum(
        _sum_fits(without_stamp(b)[1], c) for b, _, c in starred
    ) > 0.3 * len(starred)
    for number, line in enumerate(lines, 1):
        stamp, rest = without_stamp(line)
        m = _SENTENCE.match(rest)
        if not m:
            continue
        body, star, checksum = rest.strip().partition("*")
        if star and checked and not _sum_fits(body, checksum.strip()):
            damaged += 1
            continue
        values = [v.strip() for v in re.split(r"[,;\t]", body)[1:]]
        found.setdefault(m[1].lstrip("$!@#"), []).append(
            ([stamp, *values] if stamp else values, number)
        )
    known = [t for t in found if t in SENTENCES]
    tags = known or [
        t
        for t in found
        if sum(bool(re.fullmatch(NUMBER, v)) for v in found[t][0][0]) >= 3
        and not re.match(r"G[PNLAB][A-Z]{3}$|P[A-Z]{3,}", t)
    ]
    if not tags:
        return None
    tag = max(tags, key=lambda t: len(found[t]))
    rows = found[tag]
    width = Counter(len(r) for r, _ in rows).most_common(1)[0][0]
    kept = [(r, p) for r, p in rows if len(r) == width]
    stamped = PREFIX.match(lines[kept[0][1] - 1]) is not None
    heads = SENTENCES.get(tag, "").split()
    if heads:
        heads = heads[: width - stamped]
        heads += [f"field {i + 1}" for i in range(len(heads), width - stamped)]
        header = ["clock"] * stamped + heads
    else:
        header = None
    table = as_table(header, kept, len(rows) - len(kept) + damaged)
    others = sum(len(v) for t, v in found.items() if t != tag)
    if table and others:
        note = f"Sentences of other kinds than {tag} ({others:,}) were left out."
        table = Table(table.text, table.lines, (*table.notes, note))
    return table


def _sum_fits(body: str, checksum: str) -> bool:
    """Whether the two hexadecimal digits after the star are the exclusive or of the characters; a
    longer one (CRC) is not asked."""
    if not re.fullmatch(r"[0-9A-Fa-f]{2}", checksum):
        return True
    total = 0
    for c in body.lstrip("$!@#").encode():
        total ^= c
    return total == int(checksum, 16)
