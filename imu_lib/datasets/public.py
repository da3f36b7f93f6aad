"""The public records: what `data/registry.json` lists, found in IMU_LIB_DATA, in the cache, or
fetched from their source.
"""

from __future__ import annotations

import json
import sys
from functools import cache
from pathlib import Path
from types import MappingProxyType

from imu_lib.datasets import convert, places
from imu_lib.drive import Drive
from imu_lib.errors import InputError
from imu_lib.readers import read_drive, read_record
from imu_lib.record import Record


@cache
def registry() -> MappingProxyType:
    """Name -> entry: kind (static, drive, calibration), sensor, about, rate, columns, licence,
    files, options of the reader, sources (url, sha256, bytes)."""
    return MappingProxyType(
        json.loads((places.shipped() / "registry.json").read_text(encoding="utf-8"))
    )


def entry(name: str) -> dict:
    """The registry's entry. InputError where there is none of that name."""
    found = registry().get(Path(name).stem if name not in registry() else name)
    if found is None:
        raise InputError(
            f"{name!r} is not in the registry; `imu-lib data list` shows the names: "
            f"{', '.join(registry())}."
        )
    return found


def _found(name: str) -> list[Path] | None:
    files = entry(name)["files"]
    for folder in (places.given(), places.cache()):
        if folder is not None and all((folder / f).is_file() for f in files):
            return [folder / f for f in files]
    return None


def available(name: str) -> bool:
    """Whether the record can be had without a download."""
    return _found(name) is not None


def paths(name: str) -> list[Path]:
    """The record's files; fetched where they are not at hand."""
    return _found(name) or fetch(name)


def load(name: str):
    """A Record (static), a Drive (drive), or for a calibration session the Record where it is in
    SI, else a dict of its arrays.

    InputError where it is not at hand and cannot be fetched.
    """
    about = entry(name)
    files = paths(name)
    if about["kind"] == "drive":
        return read_drive(files[0])
    if name == "xsens_mti_poses":
        from imu_lib.archive import load_arrays

        return load_arrays(files[0])  # counts: their scale is what its calibration is to find
    if name == "phone":
        return read_record(gyro=files[0], accel=files[1], **about["options"])
    return read_record(files[0], **about["options"])


def fetch(name: str, *, progress: bool = False) -> list[Path]:
    """Download a record's originals, check their SHA-256, convert them; returns the files in the
    cache. InputError names what failed.
    """
    import pooch

    about = entry(name)
    folder = places.cache()
    originals = []
    for source in about["sources"]:
        file = f"{source['sha256'][:12]}-{source['url'].rpartition('/')[2]}"
        try:
            originals.append(
                Path(
                    pooch.retrieve(
                        source["url"],
                        known_hash=f"sha256:{source['sha256']}",
                        fname=file,
                        path=folder / "originals",
                        progressbar=progress and sys.stderr.isatty(),
                    )
                )
            )
        except ValueError as error:
            raise InputError(
                f"{source['url']} is not what the registry describes "
                f"({str(error).splitlines()[0][:80]}); it changed at its source."
            ) from None
        except (
            Exception
        ) as error:  # requests, urllib3, ssl and the operating system all have their own
            raise InputError(
                f"{name} is not at hand and {source['url']} cannot be fetched "
                f"({type(error).__name__}); set IMU_LIB_DATA to a folder that holds "
                f"{about['files'][0]}, or try again with a network."
            ) from None
    if about["convert"] is None:
        raise InputError(
            f"{name}: the original was fetched to {originals[0].parent} but needs conversion. "
            f"{about['how']} Put the result at {folder / about['files'][0]}."
        )
    targets = [folder / f for f in about["files"]]
    for target in targets:
        target.parent.mkdir(parents=True, exist_ok=True)
    convert.CONVERSIONS[about["convert"]](originals, targets)
    return targets


__all__ = ["Drive", "Record", "available", "entry", "fetch", "load", "paths", "registry"]
