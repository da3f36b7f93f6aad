"""What is wrong with a record or missing in its model, what limits it, and what to record next."""

from __future__ import annotations

import numpy as np

from imu_lib import report, units
from imu_lib.gap import table
from imu_lib.verdict.datasheet import coefficient

#: A Gauss-Markov process needs 200 correlation times for its variance to 10 %.
TIMES = 200.0
OFF = 0.005  # share of gravity by which |f| may be off without a word
UNLIKELY = 1e-3
SHOWN = 4  # places of one effect that a verdict lists
UNSURE = 0.1  # confidence below which a name is no more than one of several
#: Effects whose name in the model file is no word of a sentence.
SPELT = {
    "gauss_markov": "Gauss-Markov process",
    "gauss_markov_2": "Gauss-Markov process of second order",
    "autoregressive": "autoregressive noise",
    "common_mode": "noise in common",
}
APART = 10.0  # s from which on two jumps of one channel are two


def effect_name(effect: str) -> str:
    """An effect as the first word of a sentence."""
    words = SPELT.get(effect, effect).replace("_", " ")
    for short in ("gnss", "imu"):
        words = words.replace(short, short.upper())
    return words[0].upper() + words[1:]


def means(record) -> list[str]:
    """Turn-on biases of the gyros, and the length of the specific force against gravity."""
    out = []
    gyros = [c for c in record.channel_names if c.startswith("gyro")]
    if gyros:
        values = {c: np.nanmean(record.channels[c]) / units.DEG_PER_S for c in gyros}
        listed = ", ".join(f"{c[-1]} {report.number(v, 3)}" for c, v in values.items())
        out.append(
            f"Mean of the gyros, deg/s: {listed}. It is turn-on bias and at most 0.004 deg/s of "
            "Earth rate."
        )
    axes = [f"accel_{a}" for a in "xyz"]
    if all(a in record for a in axes):
        force = float(np.linalg.norm([np.nanmean(record.channels[a]) for a in axes]))
        off = force / units.G - 1.0
        if force < 0.5 * units.G:
            out.append(
                f"The mean specific force is {force:.3g} m/s^2: gravity has been taken out, and "
                "nothing can be said about the accelerometers' bias."
            )
        else:
            judged = (
                "within what gravity varies over the Earth"
                if abs(off) < OFF
                else f"{100 * abs(off):.1f} % {'above' if off > 0 else 'below'} gravity, a scale "
                f"factor or biases of up to {abs(off) * 1e3:.0f} mg; poses tell which"
            )
            out.append(f"|f| = {force:.4f} m/s^2 against {units.G:.4f} m/s^2: {judged}.")
    return out


def anomalies(health, found=None) -> list[str]:
    """Findings of the health check, then effects that the fitted model does not have, with their
    physical reading.

    health : imu_lib.health.Health; found : what `imu_lib.verdict.missing` gave, or None
    """
    out = list(health.findings)
    if found is None:
        return out
    reports = [look for _, look in found.looks]
    told = {}
    for name, step in _once(reports):
        parameters = table.describe(step, name).removeprefix(step.effect).strip()
        places = told.setdefault((step.effect, step.cause), {})
        places.setdefault(parameters, []).append((name, step))
    unsure = []
    for (effect, cause), places in told.items():
        every = [found for steps in places.values() for found in steps]
        weak = sorted({channel for channel, s in every if s.confidence < UNSURE})
        if weak:
            unsure.append(f"{effect.replace('_', ' ')} ({', '.join(weak)})")
        seen = [_place(parameters, kept) for parameters, kept in _sure(places).items()]
        if not seen:
            continue
        name = effect_name(effect)
        more = len(seen) - SHOWN
        if more > 0:
            seen[SHOWN:] = [f"and {more} more of the kind (the page on the gap has all)"]
        out.append(f"{name}. {cause} Seen in {'; '.join(seen)}.")
    if unsure:
        out.append(
            "Something more is there whose name is not sure, one in ten at best; most likely are "
            f"{'; '.join(unsure)}. The page on the gap has their rivals."
        )
    out += [_of_record(s) for r in reports for s in r.record_steps if not _known(s, health)]
    for what, look in found.looks:
        for name, channel in look.channels.items():
            if channel.result.unexplained:
                out.append(f"{name}, unexplained in {what}: {channel.result.unexplained}.")
        if look.record_unexplained:
            out.append(f"Unexplained in {what}: {look.record_unexplained}.")
        if look.stretch is not None and look.stretch[0] > 0.0:
            out.append(
                f"Times of the effects in {what} count from {look.stretch[0]:.6g} s of it on."
            )
    if any(c.result.steps and c.result.unexplained for r in reports for c in r.channels.values()):
        out.append(
            "A name beside something unexplained is as sure as such names were right in records "
            "whose causes are known: rarely, where it is a noise."
        )
    return out + [found.note] * bool(found.note)


def _sure(places) -> dict:
    """Parameters -> (channel, step) of what is more than one name of several."""
    kept = {p: [(c, s) for c, s in steps if s.confidence >= UNSURE] for p, steps in places.items()}
    return {parameters: steps for parameters, steps in kept.items() if steps}


def _once(reports):
    """(channel, step) of all looks; what an earlier look has found already is left out."""
    found = []
    for look in reports:
        steps = [(name, s) for name, c in look.channels.items() for s in c.result.steps]
        found += [new for new in steps if not any(_same(*new, *old) for old in found)]
    return found


def _same(name, step, other, before) -> bool:
    """Whether two looks at one record have found the same thing."""
    times = [s.parameters.get("time", 0.0) for s in (step, before)]
    return (name, step.effect) == (other, before.effect) and abs(times[0] - times[1]) < APART


def _known(step, health) -> bool:
    """Whether the health check has told it."""
    said = step.where.rstrip(".")
    return step.effect == "time_gaps" or any(line.startswith(said) for line in health.findings)


def _of_record(step) -> str:
    """What acts on several channels: where it shows, which may be a sentence of its own."""
    where = step.where.rstrip(".")
    if where[:1].isupper():
        return f"{where}."
    told = " ".join(table.describe(step, "record").split()).removeprefix(step.effect).strip()
    name = effect_name(step.effect)
    return f"{name}: {told}; {where}."


def _place(parameters, steps) -> str:
    """Where one finding was made, alike channels together."""
    names = [name for name, _ in steps]
    where = f" ({steps[0][1].where})" if len(steps) == 1 else ""
    sure = [s.confidence for _, s in steps]
    told = (
        f"{min(sure):.2g}"
        if max(sure) - min(sure) < 0.01
        else f"{min(sure):.2g} to {max(sure):.2g}"
    )
    return f"{', '.join(names)}: {parameters}{where}, confidence {told}"


def limits(record, result, health) -> list[str]:
    """What this record, the sound part of what was recorded, cannot say, and why."""
    length = record.duration
    lasts = f"It lasts {units.duration(length)}"
    if length < 0.99 * health.clock.duration:
        lasts = (
            f"Of its {units.duration(health.clock.duration)} the numbers use one stretch of "
            f"{units.duration(length)}"
        )
    out = [
        f"{lasts}: the variance of a slow error is known to 10 % where "
        f"its correlation time is below {report.number(length / TIMES, 2)} s, and nothing is known "
        f"of errors slower than about {units.duration(length / 3)}."
    ]
    for sensor in report.sensors(result):
        names = [c for c in result.channels if c.startswith(sensor)]
        printed = {s: [coefficient(result.channels[c], s) for c in names] for s in ("B", "K")}
        absent = [s for s, es in printed.items() if not any(e is not None and e.shown for e in es)]
        if absent:
            word = "gyros" if sensor == "gyro" else "accelerometers"
            out.append(f"Of the {word} it shows no {' and no '.join(absent)}, only upper limits.")
    bad = [c for c, r in result.channels.items() if r.choice.p_value < UNLIKELY]
    if bad:
        out.append(
            f"No sum of noise processes explains {', '.join(bad)} (p below {UNLIKELY:g}): the "
            "intervals there hold for the model, not for what it leaves out."
        )
    for name, channel in health.channels.items():
        if channel.resolution and channel.resolution > channel.sd:
            out.append(
                f"The output step of {name} is {channel.resolution / channel.sd:.1f} times its "
                "standard deviation: rounding hides the noise."
            )
    if record.temperature is None:
        out.append("The temperature was not recorded: a drift cannot be told from a warming.")
    return out


def next_record(record, result, health) -> list[str]:
    """What to record next, in the order in which it helps."""
    out = []
    times = [
        r.likelihood["correlation_time"].value
        for r in result.channels.values()
        if "correlation_time" in r.likelihood and r.likelihood["correlation_time"].shown
    ]
    wanted = max([TIMES * max(times, default=0.0), 4 * 3600.0])
    if record.duration < wanted:
        hours = min(max(4.0, np.ceil(wanted / 3600.0)), 48.0)
        why = (
            f"200 times the longest correlation time found, {report.number(max(times), 3)} s"
            if times and TIMES * max(times) > 4 * 3600.0
            else "what bias instability and walks ask for"
        )
        out.append(f"{hours:g} hours at rest, on a heavy table, away from fans and people ({why}).")
    if record.temperature is None:
        out.append("The temperature with it, of the sensor itself where it has one.")
    if health.clock.gap_count or health.clock.repeats:
        out.append("A log without lost or repeated samples: stamps of the sensor, not of the host.")
    if any(c.resolution and c.resolution > 0.5 * c.sd for c in health.channels.values()):
        out.append("A finer output format or a smaller measuring range: the steps are coarse.")
    if health.motion.gravity is not None and abs(health.motion.gravity / units.G - 1.0) > OFF:
        out.append(
            "24 or more poses put down by hand, three seconds each, for `imu-lib calibrate`."
        )
    out.append("The same again on another day: what changes from one switch-on to the next.")
    return out
