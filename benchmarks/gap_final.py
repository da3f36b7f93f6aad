"""The model that the gap workflow ends with, base and steps together, against the truth.

What was named says little of a free base, which may hold the same noise under another name. Here
the noises of the final model are compared with those that were drawn: their kinds, their spectrum
within its own 95 % band at every frequency, their parameters within their 95 % intervals. The truth
is the generator's (tests/gap_generator.py), which shares no code with the package.
"""

from __future__ import annotations

from collections import Counter

import gap_hidden as hidden
import gap_noises as noises
import numpy as np

from imu_lib.processes import Sum

#: Frequencies at which spectra are compared, and the accuracy of a spectrum that is no error.
FREQUENCIES, ACCURACY = 160, 0.01
#: Effects behind which the spectrum of the noises is still that of the samples.
JUDGED = (*hidden.SPECTRAL, *hidden.DRIFTS, "sinusoid", "parameter_change")


def truth(made, channel):
    """Entries of the noises that were drawn in a channel, or None where electronics hide them."""
    entries = [dict(e) for e in made.base[channel]]
    for t in made.truths:
        if t["channel"] == "record" and channel in t.get("parameters", {}).get("channels", ()):
            return None
        if t["channel"] != channel:
            continue
        if t["effect"] not in JUDGED:
            return None
        p = t["parameters"]
        if t["effect"] == "parameter_change":
            changed = next(
                e for e in entries if e["process"] == p["process"] and e[p["name"]] == p["from"]
            )
            changed[p["name"]] = p["to"]
        elif "process" in p:
            entries.append(p)
    return entries


def judged(made, report) -> dict:
    """Channel -> kinds, spectrum and parameters of its final model against the truth."""
    out = {}
    for channel, found in report.channels.items():
        entries = truth(made, channel)
        if entries is None or not found.result.likely:
            continue
        models = [_noise(m) for m in found.result.likely]
        final = _noise(found.result.model)
        want = Counter(e["process"] for e in entries)
        have = Counter(t.name for t in final.terms)
        inside, count = _parameters(entries, models)
        out[channel] = {
            "kinds": want == have,
            "missing": sorted((want - have).elements()),
            "extra": sorted((have - want).elements()),
            **_spectrum(entries, models, made.fs, len(made.channels[channel])),
            "parameters": [inside, count],
        }
    return out


def _noise(model) -> Sum:
    low_pass = model.low_pass
    return Sum(model.noise.terms, () if low_pass is None else (low_pass,))


def _spectrum(entries, models, fs, n) -> dict:
    """Whether the true spectrum lies within the band that holds 95 % of the models at every
    frequency at once, and where it is furthest off.
    """
    f = np.geomspace(2 * fs / n, 0.49 * fs, FREQUENCIES)
    true = np.log(noises.base_psd(entries, f, fs))
    log = np.log([m.psd(f, fs) for m in models])
    middle, sd = log.mean(axis=0), np.hypot(log.std(axis=0), ACCURACY)
    width = np.quantile(np.max(np.abs(log - middle) / sd, axis=1), 0.95)
    off = np.abs(true - middle) / sd
    j = int(np.argmax(off))
    return {
        "spectrum": bool(off[j] <= max(width, 1.96)),
        "at": float(f[j]),
        "decibel": float(10 / np.log(10) * (true - middle)[j]),
        "over_width": float(off[j] / max(width, 1.96)),
    }


def _parameters(entries, models) -> tuple[int, int]:
    """Parameters of the true noises within 95 % of the models', of those that have such a noise."""
    inside = count = 0
    seen: Counter = Counter()
    for entry in entries:
        place = seen[entry["process"]]
        seen[entry["process"]] += 1
        same = [[t for t in m.terms if t.name == entry["process"]] for m in models]
        same = [terms[place] for terms in same if len(terms) > place]
        if len(same) < len(models) / 2:  # most have no such noise
            continue
        for name, value in entry.items():
            sampling = name in ("phi", "rate") and entry["process"] != "telegraph"
            if name == "process" or sampling:
                continue
            low, high = np.quantile([getattr(t, name) for t in same], [0.025, 0.975])
            if high > low * (1 + 1e-9):  # held parameters are the truth's own
                count += 1
                inside += bool(low <= value <= high)
    return inside, count


def row(results) -> dict:
    """Counts over the judged channels of stored cases."""
    judged = [c for r in results for c in r.get("final", {}).values()]
    inside, count = np.sum([c["parameters"] for c in judged], axis=0) if judged else (0, 0)
    return {
        "final": len(judged),
        "final_kinds": sum(c["kinds"] for c in judged),
        "final_spectrum": sum(c["spectrum"] for c in judged),
        "final_parameters": [int(inside), int(count)],
    }
