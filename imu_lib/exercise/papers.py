"""The files of a class: a folder for each student, a key for the teacher, marks with feedback."""

from __future__ import annotations

import contextlib
import csv
import json
import re
from pathlib import Path

import numpy as np

from imu_lib.errors import InputError
from imu_lib.exercise import drives
from imu_lib.exercise import hidden as blind
from imu_lib.exercise.answers import read_json, student_of
from imu_lib.exercise.marking import mark
from imu_lib.writers import arrays, check_folder

KEY, ANSWERS = "key.json", "answers.json"
SHEET = """# The blind sensor, number {name}

`record.npz` is {minutes:g} minutes at rest of a sensor that nobody else has, at {rate:g} Hz: three gyros (rad/s) and three
accelerometers (m/s^2), turn-on bias and gravity taken out. `model.json` is what its data sheet says: white noise and a
Gauss-Markov process for each channel. It does not say everything. **Two or three effects are hidden, each on a channel of
its own.** Find where, name them, and give their parameters in SI units.

The names to choose from, with the parameters that are asked for:

{catalogue}

Write your answers into `answers.json`, a list for each channel in which you found something:

```json
{{"student": "{name}",
 "channels": {{"gyro_x": [{{"effect": "step", "parameters": {{"amplitude": 1e-4, "time": 310.0}}}}]}}}}
```

For each effect 60 % of the mark are for its name under its channel and 40 % for its parameters. A wrong name earns
nothing, and each name for something that is not there takes back a fifth of an effect's mark: an empty list is better
than a guess.

Useful: `imu-lib check record.npz`, `imu-lib characterise record.npz`, `imu-lib simulate model.json`, the chapters on the
spectrum, the Allan variance and the simulation gap. Whoever uses `imu-lib gap` has to explain its answer.
"""
DRIVE_SHEET = """# The blind drive, number {name}

`drive.npz` is {minutes:g} minutes of a car that nobody else has: three gyros (rad/s) and three accelerometers (m/s^2) at
{rate:g} Hz, in the body's axes, and fixes {fixes:g} times a second with velocities and their standard deviations. `model.json`
is the noise of the sensor in the car. What neither says: **two or three effects are hidden.** Find them, and give their
parameters in SI units; the antenna is as high as the sensor.

The names to choose from, with the parameters that are asked for (three values are the body axes forward, right, down):

{catalogue}

Write your answers into `answers.json`:

```json
{{"student": "{name}", "drive": [{{"effect": "gnss_time_offset", "parameters": {{"offset": 0.12}}}}]}}
```

For each effect 60 % of the mark are for its name and 40 % for its parameters. Each name for something that is not there
takes back a fifth of an effect's mark.

Useful: `imu-lib check drive.npz`, `imu-lib outages drive.npz --model model.json`, the chapters on the filter and on the
innovations of a drive. Whoever uses `imu-lib gap drive.npz --model model.json` has to explain its answer.
"""


def write_class(
    folder,
    count: int,
    seed: int,
    *,
    kind: str = "record",
    minutes: float = 30.0,
    rate: float = 50.0,
) -> Path:
    """Write `count` students' folders and the teacher's key into `folder`; returns the key's path.

    `kind` is "record" (a sensor at rest) or "drive" (a car; `rate` is then that of `drives`).
    Student i of a seed always gets the same. Raises InputError where the folder is there
    and holds something.
    """
    folder = Path(folder)
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise InputError(f"{folder} is there already; name a new folder with --out.")
    check_folder(folder)
    make = _drive if kind == "drive" else _record
    rate = drives.RATE if kind == "drive" else rate
    key = {"seed": seed, "kind": kind, "minutes": minutes, "rate": rate, "students": {}}
    folder.mkdir(parents=True, exist_ok=True)
    for number in range(1, count + 1):
        name = f"{number:0{max(2, len(str(count)))}d}"
        own = folder / f"student_{name}"
        own.mkdir()
        case = make(own, name, np.random.default_rng([seed, number]), minutes, rate)
        case.base.save(own / "model.json")
        key["students"][name] = [
            {"channel": c, "effect": e, "parameters": p} for c, e, p in case.hidden
        ]
    _write_json(folder / KEY, key)
    return folder / KEY


def _record(own: Path, name: str, rng, minutes: float, rate: float):
    """A student's record at rest, with sheet and empty answers."""
    case = blind.draw(rng, minutes=minutes, rate=rate)
    np.savez_compressed(own / "record.npz", **arrays(case.record))
    scale, rng = blind.Scale(1.0, 1.0, 1800.0, 50.0), np.random.default_rng(0)
    lines = [f"- `{e}`: {', '.join(make(scale, rng))}" for e, make in blind.EFFECTS.items()]
    text = SHEET.format(name=name, minutes=minutes, rate=rate, catalogue="\n".join(lines))
    (own / "sheet.md").write_text(text, encoding="utf-8")
    _write_json(own / ANSWERS, {"student": name, "channels": {}})
    return case


def _drive(own: Path, name: str, rng, minutes: float, rate: float):
    """A student's drive, with sheet and empty answers."""
    case = drives.draw(rng, minutes=minutes)
    case.drive.save(own / "drive.npz")
    rng = np.random.default_rng(0)
    lines = [f"- `{e}`: {', '.join(make(rng))}" for e, make in drives.EFFECTS.items()]
    text = DRIVE_SHEET.format(
        name=name, minutes=minutes, rate=rate, fixes=drives.FIXES, catalogue="\n".join(lines)
    )
    (own / "sheet.md").write_text(text, encoding="utf-8")
    _write_json(own / ANSWERS, {"student": name, "drive": []})
    return case


def key_of(answers: Path) -> Path:
    """The teacher's key beside the answers or in a folder above them; InputError without one."""
    start = answers if answers.is_dir() else answers.parent
    for folder in (start, *start.resolve().parents[:2]):
        if (folder / KEY).is_file():
            return folder / KEY
    raise InputError(
        f"there is no {KEY} beside {answers} or above it; name the one that `imu-lib exercise new` "
        "wrote with --key."
    )


def mark_all(answers, key, *, faulty: dict | None = None) -> dict:
    """Student -> Mark of a file of answers, or of every `answers*.json` in a folder.

    With `faulty` a file that cannot be marked does not stop the others: it becomes path -> sentence
    there, and where none can be marked InputError says all of them. Without `faulty` the first
    raises it. The empty sheet of a student who answered in another file is passed over.
    """
    answers = Path(answers)
    if not answers.exists():
        raise InputError(f"{answers} does not exist; name a file of answers or their folder.")
    content = read_json(Path(key))
    if not isinstance(content, dict) or not isinstance(content.get("students"), dict):
        raise InputError(f"{key} is no key of an exercise; name the one that was written with it.")
    paths = _files(answers) if answers.is_dir() else [answers]
    if not paths:
        raise InputError(f"{answers} holds no file answers*.json.")
    marks, faults = {}, {}
    for path in paths:
        try:
            name, found = _marked(path, content, key)
            if name in marks and _empty(path):
                continue  # the sheet as it was handed out, beside the one that was filled in
            if name in marks:
                raise InputError(f"{path}: student {name} has answered in another file already.")
            marks[name] = found
        except InputError as problem:
            faults[path] = str(problem)
    if faults and faulty is None:
        raise InputError(next(iter(faults.values())))
    if faults and not marks:
        raise InputError("\n".join(faults.values()))
    if faulty is not None:
        faulty |= faults
    return dict(sorted(marks.items()))


def _files(folder: Path) -> list[Path]:
    """Every file of answers below a folder, empty sheets last."""
    found = [
        p for p in folder.rglob("*") if re.fullmatch(r"answers.*\.json", p.name, re.IGNORECASE)
    ]
    return sorted(found, key=lambda path: (_empty(path), path))


def _empty(path: Path) -> bool:
    """Whether it is the sheet as it was handed out; what cannot be read is not."""
    with contextlib.suppress(InputError):
        given = read_json(path)
        if isinstance(given, dict):
            return "student" in given and not (given.get("channels") or given.get("drive"))
    return False


def _marked(path: Path, content: dict, key) -> tuple:
    given = read_json(path)
    name = student_of(given, path, content["students"], key)
    truth = [(h["channel"], h["effect"], h["parameters"]) for h in content["students"][name]]
    return name, mark(truth, given, length=60.0 * content["minutes"], where=str(path))


def write_marks(marks: dict, folder, faulty: dict | None = None) -> None:
    """`marks.csv` for the class and `feedback_NAME.md` for each student; what could not be marked
    (`faulty`, path -> sentence) stands below the marks.
    """
    folder = Path(folder)
    check_folder(folder)
    folder.mkdir(parents=True, exist_ok=True)
    with open(folder / "marks.csv", "w", newline="", encoding="utf-8") as file:
        table = csv.writer(file)
        table.writerow(["student", "points", "hidden", "named", "wrong", "note"])
        for name, m in marks.items():
            table.writerow([name, f"{m.points:.1f}", m.hidden, m.named, m.wrong, ""])
        for path, sentence in (faulty or {}).items():
            name = path.parent.name.removeprefix("student_")
            table.writerow([name, "", "", "", "", f"not marked: {sentence}"])
    for name, m in marks.items():
        lines = [f"# Student {name}: {m.points:.0f} of 100", "", *(f"- {t}" for t in m.feedback)]
        (folder / f"feedback_{name}.md").write_text("\n".join(lines) + "\n", encoding="utf-8")


def _write_json(path: Path, content) -> None:
    path.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")
