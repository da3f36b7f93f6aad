"""What the search found, as the steps of the report: names, parameters, intervals, where."""

import numpy as np
from scipy.spatial.transform import Rotation

from imu_lib.units import DEG

from . import columns, correct, posterior, random_effects, select
from .battery import SURE, battery
from .effects import CATALOGUE, LINEAR

SUREST = 0.999  # no confidence above this is claimed
ALIKE = 3.0  # nats
ABSURD = 100.0  # times the model's level
ANGLES = ("roll", "pitch", "yaw")
TURNED = np.array([5.0, 4.0, 4.0])  # standard deviations from which on a case is turned
SEEN = 3.0 * DEG  # of a mounting angle: what the drive does not show of it is said


def _step(effect, parameters, intervals, confidence, runner, alike, gaps, gain, where=None):
    return {
        "effect": effect,
        "parameters": parameters,
        "intervals": intervals,
        "where": where or CATALOGUE[effect].words,
        "cause": CATALOGUE[effect].cause,
        "confidence": float(min(confidence, SUREST)),
        "runner_up": runner,
        "indistinguishable": list(alike),
        "gap_before": float(gaps[0]),
        "gap_after": float(gaps[1]),
        "log_likelihood_gain": float(gain),
    }


def of(state, first, noise, rng, before):
    """Steps of the linear effects and of the changes of what is random, the largest gain first."""
    kept = [e for e in state.kept if e in LINEAR]
    index = [i for e in state.kept for i in select.GROUPS[e]]
    values, cov, total = state.reg.solve(index)
    sd = dict(zip(index, np.sqrt(np.diag(cov))))
    values = dict(zip(index, values))
    names = [n for n in select.GROUPS if n not in state.kept]
    sure = select.confidence(state.reg, state.kept, names, state.apart)
    out, gap = [], before.index
    gains = {
        e: total - state.reg.solve([i for k in state.kept if k != e for i in select.GROUPS[k]])[2]
        for e in kept
    }
    done = [e for e in state.kept if e not in LINEAR]
    plain = state.problem.evaluate(noise, sens=True, use=state.use)
    reg = select.regression(state.problem, plain, state.theta, state.use)
    for effect in sorted(kept, key=gains.get, reverse=True):
        done.append(effect)
        after = _gap_with(state, plain, reg, done, rng)
        part = LINEAR[effect].columns
        now = np.array([values[i] for i in part])
        confidence, second, chance, rivals = sure[effect]
        top = select.score_of(state.reg, state.kept)
        alike = [e for e, v in rivals.items() if top - v < ALIKE and e in LINEAR]
        parameters = LINEAR[effect].parameters(now)
        intervals = LINEAR[effect].intervals(now, np.array([sd[i] for i in part]))
        if effect == "gnss_time_offset":
            parameters, intervals = _one_offset(state, index, values, parameters, intervals)
        out.append(
            _step(
                effect,
                parameters,
                intervals,
                confidence,
                {"effect": second, "confidence": float(chance)},
                alike,
                (gap, after),
                gains[effect] * state.reg.temper,
            )
        )
        gap = after
    original = noise.model
    for found in sorted(state.changes, key=lambda c: -c.gain):
        noise = found.change.enter(noise, found.values)
        result = state.evaluate(noise)
        after = battery(state.problem, result.e, state.use, rng).index
        out.append(_random_step(state, found, original, (gap, after)))
        gap = after
    return out


def _one_offset(state, index, values, parameters, intervals):
    """The time offset as one number, unless the velocity clearly has one of its own."""
    a, b = columns.of("gnss_time_offset")
    if not state.use[:, 3].any():
        return ({k: d[k] for k in ("offset",)} for d in (parameters, intervals))
    _, cov, _ = state.reg.solve(index)
    i, j = index.index(a), index.index(b)
    pair = cov[np.ix_([i, j], [i, j])]
    apart = values[b] - values[a]
    if abs(apart) > 3.5 * np.sqrt(pair[0, 0] + pair[1, 1] - 2 * pair[0, 1]):
        return parameters, intervals
    weight = np.linalg.solve(pair, np.ones(2))
    one = float(weight @ [values[a], values[b]] / weight.sum())
    half = 1.96 / float(np.sqrt(weight.sum()))
    return {"offset": one}, {"offset": [one - half, one + half]}


def _gap_with(state, plain, reg, effects, rng):
    """Gap index with the linear effects given, at the path as it is."""
    index = [i for e in effects for i in select.GROUPS[e]]
    x, _, _ = reg.solve(index)
    theta = np.zeros(len(columns.ALL))
    theta[index] = x
    e = plain.e + np.einsum("fkp,p->fk", plain.jac, state.theta - theta)
    return battery(state.problem, e, state.use, rng).index


def _random_step(state, found, first, gaps):
    change = found.change
    intervals = posterior.intervals(state, found)
    parameters = change.describe(found.values)
    if change.effect == "bias_model":
        parameters = {
            "channel": parameters["channel"], "process": parameters["process"],
            "name": parameters["name"], "from": _stated(first, parameters), "to": parameters["to"],
        }  # fmt: skip
    prices = random_effects.penalty(change)
    rivals = [(e, v) for e, v, key in found.rivals if e != change.effect or key[0] == "bias_model"]
    weights = [np.exp(min(v, 0.0)) for _, v in rivals] + [np.exp(-max(found.gain - prices, 0.0))]
    names = [e for e, _ in rivals] + ["nothing"]
    total = 1.0 + sum(weights)
    k = int(np.argmax(weights))
    alike = sorted({e for (e, v) in rivals if v > -ALIKE and e != change.effect})
    return _step(
        change.effect, parameters, intervals, 1.0 / total,
        {"effect": names[k], "confidence": float(weights[k] / total)}, alike, gaps, found.gain,
    )  # fmt: skip


def _stated(model, parameters):
    """The value of a process's parameter in the model as it was given."""
    for process in model[parameters["channel"]].terms:
        if process.name == parameters["process"]:
            return float(getattr(process, parameters["name"]))
    return None


def axes(permutation, sure, runner, gain, alike, before):
    where = f"the readings follow the fixes' accelerations and turns when x, y, z of the file are taken as {', '.join(permutation)}"
    step = _step(
        "axes", {"permutation": list(permutation)}, {}, sure,
        {"effect": f"axes {' '.join(runner)}", "confidence": float(1.0 - sure)}, [],
        (before.index, before.index), gain, where,
    )  # fmt: skip
    if alike:
        step["indistinguishable"] = [f"axes {' '.join(p)}" for p in alike]
    return step


def mounting(turned, after):
    """The step, in a list, where the case is turned beyond doubt."""
    if turned is None:
        return []
    angles, sd = turned
    sizes = np.abs(angles) / sd
    if not (sizes > TURNED).any():
        return []
    names = ANGLES
    k = int(np.argmax(sizes))
    gain = 0.5 * float(np.sum(sizes**2))
    where = (
        f"on straights the velocity lies {abs(angles[2]) / DEG:.1f} deg aside of the case's x and "
        f"{abs(angles[1]) / DEG:.1f} deg above or below it ({names[k]} stands out most)"
    )
    return [
        _step(
            "mounting",
            {n: float(a) for n, a in zip(names, angles)},
            {n: [float(a - 1.96 * s), float(a + 1.96 * s)] for n, a, s in zip(names, angles, sd)},
            SUREST,
            {"effect": "nothing", "confidence": float(np.exp(-min(gain, 700.0)))},
            [],
            (after.index, after.index),
            gain,
            where,
        )  # fmt: skip
    ]


def heading(apart, sd, after, whose=""):
    """The step, in a list, where the heading given at the start is wrong beyond doubt; whose: words
    for where it was given.
    """
    sd = float(np.hypot(sd, 2.0 * DEG))
    if abs(apart) < 5.0 * sd:
        return []
    gain = 0.5 * (apart / sd) ** 2
    where = f"the path's own heading at the start, carried back by the gyros, is {abs(apart) / DEG:.0f} deg off the one given{whose}"
    return [
        _step(
            "heading",
            {"error": apart},
            {"error": [apart - 1.96 * sd, apart + 1.96 * sd]},
            SUREST,
            {"effect": "nothing", "confidence": 0.0},
            [],
            (after.index, after.index),
            gain,
            where,
        )  # fmt: skip
    ]


def arm_of_vehicle(found, drive, mount):
    """The lever arm in the vehicle's axes, with what the file gave."""
    given = np.zeros(3) if drive.lever_arm is None else np.asarray(drive.lever_arm)
    c = Rotation.from_euler("ZYX", mount[::-1])
    for step in found:
        if step["effect"] == "lever_arm":
            arm = c.apply(given + np.array(step["parameters"]["arm"]))
            half = np.array([0.5 * (b - a) for a, b in step["intervals"]["arm"]])
            step["parameters"]["arm"] = [float(a) for a in arm]
            step["intervals"]["arm"] = [[float(a - h), float(a + h)] for a, h in zip(arm, half)]


def invisible(state, turned):
    """Parameters that the drive does not excite, with upper limits; turned: the mounting's angles and
    their standard deviations, or None.
    """
    out = _angles_unseen(turned)
    for effect in LINEAR.values():
        if effect.name in ("gyro_bias", "accel_bias"):
            continue
        for i, x, sd in zip(effect.columns, *select.seen(state.reg, state.kept, effect.name)):
            fixless = columns.ALL[i].component == "velocity_offset"
            if fixless and not state.use[:, 3].any():
                continue
            if sd > 0.4 * columns.ALL[i].prior:
                out.append(
                    {
                        "effect": effect.name,
                        "parameter": columns.ALL[i].component,
                        "why": effect.unexcited,
                        "upper_limit": float(abs(x) + 1.96 * sd),
                    }
                )
    return out


def _angles_unseen(turned):
    """Entries of the mounting's angles that would have to be larger than SEEN to be named."""
    if turned is None:
        why = "the drive is too slow for its direction to show the case's"
        return [
            {"effect": "mounting", "parameter": a, "why": why, "upper_limit": float(np.pi)}
            for a in ANGLES[1:]
        ]
    why = "the path's own attitude is not known well enough: the fixes are too rough, or the drive turns and brakes too little"
    return [
        {"effect": "mounting", "parameter": a, "why": why, "upper_limit": float(abs(x) + 1.96 * s)}
        for a, x, s, least in zip(ANGLES, *turned, TURNED)
        if least * s > SEEN and abs(x) < least * s and a != "roll"
    ]


def unexplained(state, after):
    """None, or what is left: where on the drive, and in which innovation."""
    parts = []
    for when in state.restarts:
        parts.append(
            f"a shock at {when:.0f} s: there the innovations are those of a filter that lost its motion at once, and of no effect in the catalogue"
        )
    for effect in state.kept:
        if effect.startswith("other: "):
            x, _, _ = state.reg.solve([i for e in state.kept for i in select.GROUPS[e]])
            index = [i for e in state.kept for i in select.GROUPS[e]]
            sizes = ", ".join(
                f"{columns.ALL[i].component} {x[index.index(i)]:.3g}" for i in select.GROUPS[effect]
            )
            parts.append(
                f"{effect.removeprefix('other: ')} ({sizes}), which is no effect of the catalogue"
            )
    name, z = after.worst()
    if abs(z) > SURE:
        parts.append(f"{name} ({abs(z):.0f} standard deviations from what a right filter shows)")
    return "; ".join(parts) or None


def absurd(found):
    """What is said where the only noise that accounts for the innovations is one that no sensor has,
    or None.
    """
    for step in found:
        p = step["parameters"]
        if step["effect"] == "bias_model" and p["name"] != "correlation_time" and p["from"]:
            if p["to"] > ABSURD * p["from"]:
                return (
                    f"{p['process']} of {p['channel']} would be {p['to'] / p['from']:.0f} times the model's, which is no noise of a sensor: "
                    "the fixes and the readings are not of one time, body or unit, or the model is of another sensor"
                )
    return None


def worse(found, ratio, left):
    """What is said where the effects found make withheld outages worse: none of them is sure."""
    for step in found:
        step["confidence"] = min(step["confidence"], 0.5)
    said = f"what was found makes withheld outages worse ({ratio:.1f} times the error), so that the model file does not hold it"
    return said + (f"; {left}" if left else "")


__all__ = ["correct", "of", "unexplained"]
