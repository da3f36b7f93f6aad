"""What is wrong with the data, and what happened to the sensor, as a sentence."""

from __future__ import annotations

#: Effects that are the data's faults, and those of something that happened.
FAULTS = ("dropout", "held", "time_gaps", "jitter", "rate_error", "stuck", "spikes", "saturation")
TOUCHED = ("disturbance", "tilt")
JUMPS = ("step", "telegraph")
#: m/s^2.
GRAVITY = 9.80665
#: Times and parts that are told.
TIMES, PARTS = 5, 5


def _amount(p, key) -> str:
    return f"{100 * p[key]:.2g} %"


def _or_tilted(p, on: str) -> str:
    """What a jump of one accelerometer alone may be as well."""
    angle = abs(p["amplitude"]) / GRAVITY
    return f" (or it was tilted by {1e3 * angle:.2g} mrad)" if "accel" in on and angle < 0.5 else ""


#: Effect -> words from its parameters and " on CHANNEL".
WORDS = {
    "time_gaps": lambda p, on: f"{_amount(p, 'fraction')} of the samples are missing",
    "dropout": lambda p, on: f"{_amount(p, 'fraction')} of the rows are drop-outs",
    "jitter": lambda p, on: f"the time stamps scatter by {1e3 * p['sd']:.2g} ms",
    "rate_error": lambda p, on: (
        f"the clock is off: the true rate is {p['ratio']:.5g} of the stated"
    ),
    "saturation": lambda p, on: f"samples are clipped{on}",
    "stuck": lambda p, on: f"{_amount(p, 'fraction')} of the samples are frozen{on}",
    "spikes": lambda p, on: f"single samples are thrown off{on}, {60 * p['rate']:.2g} a minute",
    "step": lambda p, on: f"the level jumped{on} at {p['time']:.0f} s{_or_tilted(p, on)}",
    "telegraph": lambda p, on: (
        f"the level jumps to and fro between two values{on}, {60 * p['rate']:.2g} times a minute"
    ),
}


def sentence(steps, sure: float, left_out=()) -> str:
    """The sentence about `steps`, (channel or "record", step) of everything found; what is less
    than `sure` is in doubt; `left_out` are sentences on channels that tell nothing.
    """
    named = [(w, s) for w, s in steps if s.effect in (*FAULTS, *JUMPS)]
    parts, doubtful = [text.rstrip(".") for text in left_out], []
    for where, s in named:
        on = "" if where == "record" else f" on {where}"
        text = WORDS.get(s.effect, lambda p, on, s=s: f"{s.effect.replace('_', ' ')}{on}")
        if s.confidence >= sure or where == "record":
            parts.append(text(s.parameters, on))
        else:
            doubtful.append(f"{s.effect.replace('_', ' ')}{on}")
    touched = [s for _, s in steps if s.effect in TOUCHED]
    if touched:
        at = sorted(s.parameters.get("start", s.parameters.get("time", 0.0)) for s in touched)
        what = "moved" if any(s.effect == "tilt" for s in touched) else "touched"
        parts.append(f"it was {what} at {_times(at)} s")
    if doubtful and not parts:
        return f"Nothing is surely wrong with the data themselves, but in doubt: {', '.join(doubtful)}."
    if not parts:
        return "Nothing is wrong with the data themselves: no drop-outs, no frozen or clipped samples, nobody touched it."
    text = "; ".join(list(dict.fromkeys(parts))[-PARTS:])
    return f"{text[:1].upper()}{text[1:]}."


def _times(at) -> str:
    shown = ", ".join(f"{t:.0f}" for t in at[:TIMES])
    return shown + (f" and {len(at) - TIMES} more times" if len(at) > TIMES else "")
