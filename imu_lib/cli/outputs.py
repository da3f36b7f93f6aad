"""Where a command writes: checked before long work, put in place whole or not at all."""

from __future__ import annotations

import os
import re
import shutil
import stat
import tempfile
from contextlib import contextmanager
from pathlib import Path

from imu_lib import beside
from imu_lib.errors import InputError

#: Names of an open descriptor of this process; what they resolve to is no place to write beside.
_DESCRIPTOR = re.compile(r"/dev/(?:std(?P<name>in|out|err)|fd/(?P<d>\d+))|/proc/self/fd/(?P<p>\d+)")


def descriptor(path) -> int | None:
    """The file descriptor that a path such as /dev/stdout names, else None."""
    found = _DESCRIPTOR.fullmatch(str(path))
    if not found:
        return None
    if found["name"]:
        return ("in", "out", "err").index(found["name"])
    return int(found["d"] or found["p"])


def in_place(path) -> bool:
    """Whether `path` is a device, a pipe or a socket: written through, never replaced."""
    if descriptor(path) is not None:
        return True
    try:
        mode = os.stat(path).st_mode
    except OSError:
        return False
    return not (stat.S_ISREG(mode) or stat.S_ISDIR(mode))


def target(path) -> Path:
    """The file that is written where `path` is named: a symbolic link is followed."""
    try:
        return Path(path).resolve() if Path(path).is_symlink() else Path(path)
    except (OSError, RuntimeError):
        raise InputError(
            f"{path} is a symbolic link that leads to itself; name another file."
        ) from None


def place(temporary: Path, path) -> None:
    """A finished file takes the name `path`; a device or pipe gets its content instead."""
    if not in_place(path):
        temporary.replace(target(path))
        return
    own = descriptor(path)
    try:
        with (
            open(temporary, "rb") as content,
            open(path if own is None else os.dup(own), "wb") as out,
        ):
            shutil.copyfileobj(content, out)
    except BrokenPipeError:
        raise
    except OSError as error:
        raise InputError(
            f"{path} cannot be written to: {error.strerror}; name another file."
        ) from None


@contextmanager
def atomic_path(path):
    """A temporary path beside `path` that takes its name when the block ends well and vanishes
    otherwise. A symbolic link is followed, and a device or pipe is written through.
    """
    check_writable(path)
    if not in_place(path):
        with beside.whole(target(path)) as temporary:
            yield temporary
        return
    with tempfile.TemporaryDirectory() as folder:
        temporary = Path(folder) / f"out{Path(path).suffix}"
        yield temporary
        place(temporary, path)


@contextmanager
def atomic_folder(path):
    """A temporary folder whose files move into `path` (made if needed) when the block ends well;
    otherwise nothing is left.
    """
    path = Path(path)
    check_out(path)
    with tempfile.TemporaryDirectory(
        dir=path.resolve().parent, prefix=f".{path.name}-"
    ) as temporary:
        yield Path(temporary)
        path.mkdir(exist_ok=True)
        for item in sorted(Path(temporary).rglob("*")):
            final = path / item.relative_to(temporary)
            if item.is_dir():
                final.mkdir(exist_ok=True)
            else:
                place(item, final)


def check_writable(path) -> None:
    """InputError at once, before long work, where `path` (a file to be) has no folder, is one, or
    may not be written. `-` and None pass.
    """
    if path in (None, "-"):
        return
    if in_place(path):
        if descriptor(path) is None and not os.access(path, os.W_OK):
            raise InputError(f"{path} may not be written to; name another file.")
        return
    final = target(path)
    if final.is_dir():
        raise InputError(f"{path} is a directory; name a file to write.")
    _folder(final.parent, path)


def _folder(folder: Path, given) -> None:
    from imu_lib.writers import check_folder

    check_folder(folder, given)
    if not folder.is_dir():
        raise InputError(f"{given}: there is no folder {folder}; make it first.")


def check_out(path) -> None:
    """InputError at once, before long work, where `path` (--out, a folder to be) cannot be made or
    written into. None passes.
    """
    if path is None:
        return
    path = Path(path)
    if (path.exists() or path.is_symlink()) and not path.is_dir():
        raise InputError(f"{path} is a file; --out names a folder.")
    _folder(path.resolve().parent, path)  # it is filled beside and then moved
    if path.is_dir():
        _folder(path, path)
