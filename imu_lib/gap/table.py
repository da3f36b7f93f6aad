"""The result as text for the terminal."""

from __future__ import annotations

from textwrap import wrap

from imu_lib.gap.found import Report
from imu_lib.gap.sentences import absorbed
from imu_lib.gap.sentences.parameters import describe
from imu_lib.gap.sentences.summary import sentences
from imu_lib.gap.steps import Step
from imu_lib.model import Model
from imu_lib.processes import Step as Jump

#: Columns of a terminal, or of a page of the book.
WIDTH = 110
#: What the last line says of the gap index.
GAUGED = (
    " The gap index is 1 where the measurement differs from simulations as they do among "
    "themselves."
)


def _folded(indent: int, text: str) -> list[str]:
    return wrap(
        text,
        WIDTH,
        initial_indent=" " * indent,
        subsequent_indent=" " * (indent + 2),
        break_long_words=False,
    )


def table(found: Report) -> str:
    """The whole result."""
    lines = [*wrap(" ".join(sentences(found)), WIDTH), ""]
    gauged = any(c.before is not None for c in found.channels.values())
    gap = f"{'gap before':>11}{'after':>7}{'held out':>15}" if gauged else ""
    lines += [f"{'channel':<9}{gap}  found"]
    for name, c in found.channels.items():
        r = c.result
        before = "" if c.before is None else f"{c.before.value:.2f}"
        after = "" if c.after is None else f"{c.after.value:.2f}"
        held = "" if not c.held_out else f"{c.held_out['before']:.2f} -> {c.held_out['after']:.2f}"
        gap = f"{before:>11}{after:>7}{held:>15}" if gauged else ""
        steps = r.steps and not any(name in a.channels for a in found.absent)
        lines.append(f"{name:<9}{gap}  {'' if steps else on_channel(found, name)}".rstrip())
        lines += _steps(r.steps, name)
        if not found.given:
            lines += _folded(11, f"fitted base: {', '.join(t.name for t in r.base.terms)}")
        if r.unexplained:
            lines += _folded(11, f"UNEXPLAINED: {r.unexplained}")
        if r.small:
            lines += _folded(11, f"too small to matter: {'; '.join(r.small)}")
    if found.record_steps or found.record_unexplained:
        lines.append("record")
        lines += _steps(found.record_steps, "record")
        if found.record_unexplained:
            lines += _folded(11, f"UNEXPLAINED: {found.record_unexplained}")
    lines += wrap(absorbed.sentence(found), WIDTH)
    lines.append(f"{found.seconds:.1f} s." + (GAUGED if gauged else ""))
    return "\n".join(lines)


def on_channel(found: Report, name: str) -> str:
    """What was found on a channel, in a line: its own effects, then those that stand on the record
    and that it feels.
    """
    r = found.channels[name].result
    own = [s.effect for s in r.steps]
    felt = dict.fromkeys(
        s.effect
        for s in found.record_steps
        if name in s.parameters.get("channels", ()) and s.effect not in own
    )
    if _jumps(found.model, name) > _jumps(found.base, name) + own.count(Jump.name):
        felt["tilt"] = None  # whose change of level its model has
    parts = [", ".join(own)] if own else []
    if felt:
        parts.append(f"on the record: {', '.join(felt)}")
    gone = [a.process.name for a in found.absent if name in a.channels]
    if gone:
        parts.append(f"without the given model's {', '.join(dict.fromkeys(gone))}")
    if not parts:
        if r.unexplained:
            return "left unexplained"
        if found.channels[name].before is None:
            return "nothing found; no gap index was asked for"
        return "nothing: simulation and measurement agree"
    return "; ".join(parts)


def _jumps(model: Model, name: str) -> int:
    """How many jumps the model of a channel has."""
    return sum(t.name == Jump.name for t in model[name].terms) if name in model else 0


def _steps(steps: list[Step], name: str) -> list[str]:
    out = []
    for s in steps:
        out.append(f"{'':<11}{describe(s, name)}   (confidence {s.confidence:.3g})")
        out += _folded(13, f"where: {s.where}")
        if s.indistinguishable:
            out += _folded(13, f"this record cannot tell it from: {', '.join(s.rivals)}")
    return out
