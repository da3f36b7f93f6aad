"""A fleet in one page: spreads, outliers, drift, shares, and the error model of the fleet."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from imu_lib import units
from imu_lib.fleet import questions
from imu_lib.fleet.spread import CONFIDENCE, CONTENT
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
        By channel and "method coefficient".
    outliers : tuple of dict
        channel, method, coefficient, sensor, value, expected, ratio, p_value.
    drifts : dict of str to dict of str to Estimate
        Change of the logarithm a year, where there are dates.
    days : dict of str to dict
        Scatter from sensor to sensor and from record to record of one sensor.
    shares : DataFrame
        In what share of the sensors each sum or effect is found.
    model : Model or None
        Typical coefficients; its key `spread` has the scatter and the worst of 95 %.
    """

    records: int
    sensors: int
    errors: tuple
    spreads: dict = field(repr=False)
    outliers: tuple = field(repr=False)
    drifts: dict = field(repr=False)
    days: dict = field(repr=False)
    shares: object = field(repr=False)
    model: Model | None = field(repr=False)

    def to_json(self):
        return {
            "records": self.records,
            "sensors": self.sensors,
            "errors": list(self.errors),
            "spreads": self.spreads,
            "outliers": list(self.outliers),
            "drifts": self.drifts,
            "days": self.days,
            "shares": self.shares.to_dict("records"),
        }

    def text(self) -> str:
        """Tables in datasheet units."""
        lines = [
            f"{_number(self.sensors, 'sensor')}, {_number(self.records, 'record')}, "
            f"{len(self.errors)} left out",
            "",
        ]
        if not self.spreads:
            lines.append("fewer than three sensors show a coefficient: there is no spread to tell")
        share, sure = round(100 * CONTENT), round(100 * CONFIDENCE)
        if self.spreads:
            head = ("coefficient", "unit", "sensors", "typical", "scatter", f"worst of {share} %")
            rows = [head]
            for channel, found in self.spreads.items():
                for key, s in found.items():
                    rows.append(_row(channel, key, s))
            widths = [max(len(r[i]) for r in rows) for i in range(len(head))]
            lines += [
                "  ".join(c.ljust(w) for c, w in zip(r, widths, strict=True)).rstrip() for r in rows
            ]
            lines += [
                "",
                "typical [95 % interval]; scatter: standard deviation from unit to unit, the error "
                f"of each estimate taken off; worst: {share} % of all units stay below, with "
                f"{sure} % confidence",
            ]
        for o in self.outliers:
            lines.append(
                f"outlier: {o['sensor']}, {o['channel']} {o['coefficient']} ({o['method']}) is "
                f"{o['ratio']:.3g} times what the others predict (p = {o['p_value']:.1g})"
            )
        for channel, found in self.drifts.items():
            for key, d in found.items():
                if d.low > 0 or d.high < 0:
                    lines.append(
                        f"drift: {channel} {key} changes by {100 * np.expm1(d.value):.3g} % a year "
                        f"[{100 * np.expm1(d.low):.3g}, {100 * np.expm1(d.high):.3g}]"
                    )
        return "\n".join(lines)


def _number(n, noun):
    return f"{n} {noun}{'s' * (n != 1)}"


def _row(channel, key, s):
    symbol = key.split()[-1]
    factor, unit = units.datasheet(symbol, channel)

    def number(v):
        return f"{v / factor:.4g}"

    t, c = s.typical, s.scatter
    return (
        f"{channel} {key}",
        unit,
        f"{s.shown} of {s.units}",
        f"{number(t.value)} [{number(t.low)}, {number(t.high)}]",
        f"{100 * c.value:.2g} % [{100 * c.low:.2g}, {100 * c.high:.2g}]",
        number(s.worst),
    )


def summary(table) -> Summary:
    """All of the fleet's questions on a table, as `fleet.load` gives it."""
    good = table[table.error.isna()]
    spreads, outliers, drifts, days = {}, [], {}, {}
    for channel in [c for c in CHANNELS if (good.channel == c).any()]:
        for method, coefficient in questions.KEYS:
            asked = (good, channel, method, coefficient)
            key = f"{method} {coefficient}"
            if (found := questions.spread(*asked)) is None:
                continue
            spreads.setdefault(channel, {})[key] = found
            for sensor, row in questions.outliers(*asked).iterrows():
                about = {"sensor": sensor, "channel": channel}
                outliers.append(
                    about | {"method": method, "coefficient": coefficient} | row.to_dict()
                )
            if (change := questions.drift(*asked)) is not None:
                drifts.setdefault(channel, {})[key] = change
            if (two := questions.sensor_and_day(*asked)) is not None:
                days.setdefault(channel, {})[key] = two
    shares = questions.shares(good)
    return Summary(
        int(table.file.nunique()),
        int(table.sensor.nunique()),
        tuple(table.error.dropna()),
        spreads,
        tuple(outliers),
        drifts,
        days,
        shares,
        fleet_model(good, shares, spreads),
    )


def fleet_model(table, shares, spreads) -> Model | None:
    """The error model of the fleet: on each channel the sum that most sensors have, its
    coefficients typical of the sensors; the key `spread` has `scatter` (of the logarithm) and
    `worst` of each.
    """
    channels, told, rates = {}, {}, table.rate.dropna()
    for channel in spreads:
        here = shares[shares.channel == channel]
        for name in here.sort_values("found", ascending=False).effect:
            template = SUMS.get(name)
            labels = [label for label, _, _ in template.labels()] if template else ()
            found = {
                label: questions.spread(
                    _with_sum(table, channel, name), channel, "likelihood", label
                )
                for label in labels
            }
            if labels and all(found.values()):
                channels[channel] = template.with_values(
                    {label: s.typical.value for label, s in found.items()}
                )
                told[channel] = {
                    label: {"scatter": s.scatter.value, "worst": s.worst, "units": s.units}
                    for label, s in found.items()
                }
                break
    if not channels:
        return None
    return Model(
        channels,
        rate=float(rates.median()) if len(rates) else None,
        name="fleet",
        source=f"typical of {table.sensor.nunique()} sensors",
        extra={"spread": told},
    )


def _with_sum(table, channel, name):
    """The rows of the records for which the likelihood chose this sum on the channel."""
    own = table[(table.channel == channel) & (table.effect == name)]
    return table[table.file.isin(own.file)]


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
