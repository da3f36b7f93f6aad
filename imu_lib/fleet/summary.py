"""A fleet in one page: spreads, outliers, drift, shares, and the error model of the fleet."""

from __future__ import annotations

from dataclasses import dataclass, field, fields

import numpy as np

from imu_lib.fleet import dates, outlying, page, questions, remarks
from imu_lib.likelihood import CANDIDATES as SUMS
from imu_lib.model import Model
from imu_lib.record import CHANNELS


@dataclass(frozen=True)
class Summary:
    """What a fleet's table says.

    Attributes
    ----------
    records, sensors : int
    errors : tuple of str
        The sentences on the records that could not be used.
    spreads : dict of str to dict of str to Spread
        By channel and "method coefficient", of all sensors.
    without_outliers : dict of str to dict of str to Spread
        The same without the sensors that `outliers` names for the coefficient, where it names any.
    outliers : tuple of dict
        channel, method, coefficient, sensor, value, expected, ratio, p_value.
    steps : tuple of dict
        Sensors that change between two dates unlike the others: channel, method, coefficient,
        sensor, before, after, ratio, expected, p_value.
    drifts : dict of str to dict of str to Drift
        Change of the logarithm a year, where three sensors have two dates.
    no_drift : dict of str to dict of str to str
        Why there is none of the others, in a sentence.
    days : dict of str to dict
        Scatter from sensor to sensor and from date to date of one sensor.
    shares : DataFrame
        In what share of the sensors each sum or effect is found.
    model : Model or None
        Typical coefficients; its key `spread` has the scatter and the worst of 95 %, those of
        `spreads`.
    notes : tuple of str
        What is to be known of the table.
    """

    records: int
    sensors: int
    errors: tuple
    spreads: dict = field(repr=False)
    without_outliers: dict = field(repr=False)
    outliers: tuple = field(repr=False)
    steps: tuple = field(repr=False)
    drifts: dict = field(repr=False)
    no_drift: dict = field(repr=False)
    days: dict = field(repr=False)
    shares: object = field(repr=False)
    model: Model | None = field(repr=False)
    notes: tuple = ()

    def to_json(self):
        told = {f.name: getattr(self, f.name) for f in fields(self) if f.name != "model"}
        return told | {"shares": self.shares.to_dict("records")}

    def text(self) -> str:
        """Tables in datasheet units."""
        return page.text(self)


def summary(table, notes=()) -> Summary:
    """All of the fleet's questions on a table, as `fleet.load` gives it; `notes` are told with what
    it answers.
    """
    good = table[table.error.isna()]
    spreads, without, odd, steps, drifts, no_drift, days = {}, {}, [], [], {}, {}, {}
    for channel in [c for c in CHANNELS if (good.channel == c).any()]:
        for method, coefficient in questions.KEYS:
            key = f"{method} {coefficient}"
            rows = questions.coefficients(good, channel, method, coefficient)
            dated = questions.by_date(rows)
            one = questions.by_sensor(rows, dated)
            if (found := questions.spread_of(one)) is None:
                continue
            about = {"channel": channel, "method": method, "coefficient": coefficient}
            spreads.setdefault(channel, {})[key] = found
            strange = outlying.outliers_of(one)
            odd += _rows(strange, about)
            if len(strange):
                left = questions.spread_of(one.drop(strange.index))
                without.setdefault(channel, {})[key] = left
            steps += _rows(outlying.steps_of(dated), about)
            if (change := dates.drift_of(dated)) is not None:
                drifts.setdefault(channel, {})[key] = change
            else:
                no_drift.setdefault(channel, {})[key] = dates.without_drift_of(rows, dated)
            if (two := dates.sensor_and_day_of(rows, dated)) is not None:
                days.setdefault(channel, {})[key] = two
    shares = questions.shares(good)
    return Summary(
        int(table.file.nunique()),
        int(good.sensor.nunique()),
        tuple(table.error.dropna()),
        spreads,
        without,
        tuple(odd),
        tuple(steps),
        drifts,
        no_drift,
        days,
        shares,
        fleet_model(good, shares, spreads, without),
        (*notes, *remarks.of_table(table)),
    )


def _rows(found, about):
    return [about | {"sensor": sensor} | row.to_dict() for sensor, row in found.iterrows()]


def fleet_model(table, shares, spreads, without=None) -> Model | None:
    """The error model of the fleet: on each channel the sum that most sensors have, its
    coefficients typical of all sensors (`spreads`); the key `spread` has `scatter` (of the
    logarithm), `worst` and `units` of each, and where sensors were named as outliers the same
    `without_outliers`.
    """
    channels, told, rates = {}, {}, table.drop_duplicates("file").rate.dropna()
    for channel, found in spreads.items():
        here = shares[shares.channel == channel]
        for name in here.sort_values("found", ascending=False).effect:
            template = SUMS.get(name)
            labels = [label for label, _, _ in template.labels()] if template else ()
            own = {label: found.get(f"likelihood {label}") for label in labels}
            if not labels or not all(own.values()):
                continue
            channels[channel] = template.with_values(
                {label: s.typical.value for label, s in own.items()}
            )
            told[channel] = {label: _in_model(s) for label, s in own.items()}
            for label in labels:
                less = (without or {}).get(channel, {}).get(f"likelihood {label}")
                if less is not None:
                    more = {"typical": less.typical.value} | _in_model(less)
                    told[channel][label]["without_outliers"] = more
            break
    if not channels:
        return None
    return Model(
        channels,
        rate=float(rates.mode().iloc[0]) if len(rates) else None,
        name="fleet",
        source=f"typical of {table.sensor.nunique()} sensors",
        extra={"spread": told},
    )


def _in_model(s):
    return {"scatter": s.scatter.value, "worst": s.worst, "units": s.units}


def draw(model: Model, rng: np.random.Generator) -> Model:
    """One unit of a fleet model: each coefficient its typical value times a log-normal factor of
    the fleet's scatter.
    """
    spread = model.extra["spread"]
    channels = {}
    for channel, entry in model.channels.items():
        values = {}
        for label, index, name in entry.labels():
            if label in spread.get(channel, {}):
                size = spread[channel][label]["scatter"]
                typical = getattr(list(entry)[index], name)
                values[label] = float(typical * np.exp(size * rng.standard_normal()))
        channels[channel] = entry.with_values(values)
    return model.with_channels(channels)
