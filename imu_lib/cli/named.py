"""The files that a call names: inputs that can be opened, and outputs that are none of them."""

from __future__ import annotations

import argparse
import fnmatch
import os
import re
import stat
from pathlib import Path

from imu_lib.cli import outputs
from imu_lib.errors import InputError

#: What the parsers call a file or folder that is read.
INPUTS = (
    *("file", "gyro", "accel", "gnss", "model", "static", "temperature", "poses"),
    *("drive", "a", "b", "records", "answers", "key"),
)


def check(args: argparse.Namespace) -> None:
    """InputError where an input is no file's name, or where an output of the call would take the
    place of one of its inputs or of another output.
    """
    read = [v for k in INPUTS if isinstance(v := getattr(args, k, None), str)]
    for name in read:
        _is_a_name(name)
    written = list(_written(args, read))
    for flag, path in written:
        for name in read:
            if _same(path, name) or _within(path, name):
                _refuse(flag, path, name)
    for i, (flag, path) in enumerate(written):
        for other, second in written[:i]:
            if _same(path, second):
                raise InputError(
                    f"{flag} and {other} both write {second}; give each a name of its own."
                )


def refuse_overwriting(args: argparse.Namespace, read) -> None:
    """InputError where an output of the call is one of the files `read`, which it does not name
    itself: those of a manifest, say.
    """
    known = {key: name for name in read if (key := _key(name)) is not None}
    for flag, path in _written(args, read):
        if _key(path) in known:
            _refuse(flag, path, known[_key(path)])


def _refuse(flag, path, name):
    raise InputError(
        f"{flag} would overwrite {path}, which this call "
        f"reads{'' if str(path) == str(name) else f' ({name})'}; give it another name."
    )


def _is_a_name(name: str) -> None:
    if name == "-":
        raise InputError(
            "- (standard input) is not read here; save it to a file and give the file's name."
        )
    scheme = re.match(r"([A-Za-z][A-Za-z0-9+.-]+)://", name)
    if scheme and scheme[1].lower() == "file":
        raise InputError(f"{name} is a URL; give the path alone, without file://.")
    if scheme:
        raise InputError(f"{name} is a URL, which is not opened; download it and name the file.")


def _written(args, read):
    """(flag, path) of every file that the call writes; of a folder those that are there already or
    that the call names otherwise."""
    json = getattr(args, "json", None)
    if json not in (None, "-"):
        yield "--json", Path(json)
    out, patterns = getattr(args, "out", None), getattr(args, "writes", ())
    folder = Path(out) if out is not None and patterns else Path()
    if out is not None and not patterns:
        yield "--out", Path(out)
    elif out is not None:
        near = [*read, *([] if json in (None, "-") else [json])]
        yield from (("--out", path) for path in _in_folder(folder, patterns, near))
    for form in (f for entry in getattr(args, "export", None) or () for f in entry.split(",")):
        from imu_lib import export

        if form in export.FORMATS:
            yield f"--export {form}", folder / export.FORMATS[form][0]


def _in_folder(folder, patterns, near) -> list[Path]:
    """The files of a folder that results would replace, each once; `near` may lie in it."""
    there = [folder / name for name in patterns if (folder / name).is_file()]
    for name in near:
        path, inside = outputs.target(name).resolve(), folder.resolve()
        if inside in path.parents:
            shown = path.relative_to(inside).as_posix()
            if any(fnmatch.fnmatch(shown, pattern) for pattern in patterns):
                there.append(folder / shown)
    return list({_key(path): path for path in there}.values())


def _key(path):
    """What tells a regular file from every other: device and inode, or its path while it is not
    there. None for devices, pipes and folders."""
    if outputs.descriptor(path) is not None:
        return None
    try:
        found = os.stat(path)
    except OSError:
        return str(outputs.target(path).resolve())
    return (found.st_dev, found.st_ino) if stat.S_ISREG(found.st_mode) else None


def _same(a, b) -> bool:
    return _key(a) is not None and _key(a) == _key(b)


def _within(path, folder) -> bool:
    """Whether an output is a file that is already there in a folder of inputs; JSON files in it are
    results of earlier calls, but for those of a store of arrays."""
    if not Path(folder).is_dir() or not Path(path).is_file():
        return False
    from imu_lib.readers.zarr_store import is_store

    if Path(folder).resolve() not in outputs.target(path).resolve().parents:
        return False
    if Path(path).name in ("answers.json", "key.json") or is_store(folder):
        return True
    results = (".json", ".html", ".png")
    return Path(path).suffix.lower() not in results and Path(path).name != "fleet.parquet"
