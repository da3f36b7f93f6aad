"""What a base that was fitted to the record itself may have taken for its own noise, where that
has a cause that a reader can do something about: once for the record, in a sentence.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from imu_lib import words
from imu_lib.gap.effects import DRIFTS
from imu_lib.gap.sentences import signals

if TYPE_CHECKING:
    from imu_lib.gap.found import Report

#: What has a cause of its own; a noise in the place of another is a name.
CAUSES = {e.name for e in DRIFTS}
#: How some of them are called here.
NAMES = {"sinusoid": "a slow wave", "temperature": "what follows the temperature"}


def sentence(found: Report) -> str:
    """Drifts and the temperature that would not be told from the fitted noises; nothing
    where there are none.
    """
    on: dict[tuple[str, ...], list[str]] = {}
    for effect in dict.fromkeys(e for c in found.channels.values() for e in c.result.absorbed):
        if effect not in CAUSES:
            continue
        channels = tuple(n for n, c in found.channels.items() if effect in c.result.absorbed)
        on.setdefault(channels, []).append(_named(effect))
    if not on:
        return ""
    parts = [
        f"{words.listed(names)} on "
        f"{'all channels' if len(channels) == len(found.channels) else words.names(channels)}"
        for channels, names in on.items()
    ]
    return (
        f"The base was fitted to this record, and its slow noises would follow "
        f"{'; '.join(parts)}: none is ruled out. A model of another record of this sensor "
        "(--model FILE) tells them."
    )


def _named(effect: str) -> str:
    return NAMES.get(effect) or signals.MEANING.get(effect) or effect.replace("_", " ")
