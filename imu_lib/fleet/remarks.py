"""What is to be known of a fleet's table before its numbers are used."""

from __future__ import annotations

import re

from imu_lib.record import CHANNELS
from imu_lib.words import listed, number


def of_table(table) -> tuple[str, ...]:
    """Sentences: records that are copies, names that may be one sensor, channels that some sensors
    lack, rates, and whether days are part of the scatter.
    """
    good = table[table.error.isna()]
    found = [*_copies(good), *_alike(table), *_channels(good), *_rates(good), *_one_date(good)]
    lost = set(table.sensor) - set(good.sensor)
    if lost:
        found.append(
            f"What was left out is all there is of {number(len(lost), 'sensor')}"
            f"{_some(sorted(lost))}, not counted here."
        )
    return tuple(found)


def _some(names):
    names = [str(name) for name in names]
    return f" ({', '.join(names[:4])}{' ...' * (len(names) > 4)})"


def _copies(good):
    """Records with the same numbers to the last digit: two measurements never have these."""
    rows = good[good.value.notna()]
    columns = ["channel", "method", "coefficient", "value"]
    seen = {}
    for file, own in rows.groupby("file", sort=False):
        seen.setdefault(tuple(own[columns].itertuples(index=False, name=None)), []).append(file)
    for files in seen.values():
        if len(files) > 1:
            yield (
                f"{listed(files[:4])}{' ...' * (len(files) > 4)} give the same numbers to the last "
                "digit: they are copies of one record, and each counts; remove all but one."
            )


def _alike(table):
    names = {}
    for sensor in table.sensor.unique():
        names.setdefault(re.sub(r"[\W_]+", "", str(sensor).casefold()), []).append(str(sensor))
    for alike in names.values():
        if len(alike) > 1:
            yield (
                f"{listed([repr(name) for name in alike])} differ in case or separators alone and "
                "count as different sensors; give them one name, in the files or in a manifest."
            )


def _channels(good):
    every = good.sensor.nunique()
    for channel in [c for c in CHANNELS if (good.channel == c).any()]:
        have = good[good.channel == channel].sensor
        if have.nunique() < every:
            lack = sorted(set(good.sensor) - set(have))
            yield f"{channel} is missing from {len(lack)} of {every} sensors{_some(lack)}."


def _rates(good):
    rates = good.drop_duplicates("file").rate.astype(float).round(1).value_counts()
    if len(rates) > 1:
        told = listed([f"{rate:g} Hz ({n})" for rate, n in rates.head(4).items()])
        yield (
            f"The records come at {told}{' ...' * (len(rates) > 4)}: densities (N, B, K) compare, "
            "what depends on the rate (Q, the processes that show) does so less."
        )


def _one_date(good):
    records = good.drop_duplicates("file")
    if len(records) > 2 and not records.sensor.duplicated().any():
        yield (
            "Each sensor has one record: what one sensor changes from day to day is part of the "
            "scatter from unit to unit."
        )
