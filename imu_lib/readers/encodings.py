"""Which encoding a text is in that is no UTF-8: the one in which its words are words of
headings.
"""

from __future__ import annotations

import re

from imu_lib.readers import lexicon

#: From the most frequent on: where two explain a text alike, the first is taken.
CANDIDATES = {
    "cp1252": "Western European (Windows-1252)",
    "gb18030": "Chinese (GB 18030)",
    "cp932": "Japanese (Shift JIS)",
    "big5": "Chinese (Big5)",
    "cp949": "Korean (Windows-949)",
    "euc_jp": "Japanese (EUC-JP)",
    "cp1251": "Cyrillic (Windows-1251)",
    "koi8_r": "Cyrillic (KOI8-R)",
    "cp866": "Cyrillic (DOS 866)",
    "cp1250": "Central European (Windows-1250)",
    "cp1253": "Greek (Windows-1253)",
    "cp1254": "Turkish (Windows-1254)",
}
SOME = 50  # lines that are looked at

_SIGNS = "°º²³µμ·×±−–√ω℃"
_WORDS = frozenset(
    lexicon.GYRO
    | lexicon.ACCEL
    | lexicon.ANGULAR
    | lexicon.SPEED
    | lexicon.TIME
    | lexicon.TEMPERATURE
    | lexicon.DATE
    | lexicon.words("с м мс мкс сек рад град 毫秒 微秒 秒 초 轴 軸 度")
)
_FOREIGN = re.compile(
    "|".join(sorted((w for w in _WORDS if len(w) > 1 and not w.isascii()), key=len, reverse=True))
)


def of(data: bytes, head: int) -> str | None:
    """The encoding of a text that is no UTF-8, one of `CANDIDATES`; None where no words tell, or
    it is UTF-8 or wider.

    Parameters
    ----------
    data : bytes
        The file.
    head : int
        Bytes from its start in which words are looked for.
    """
    joined = foreign(data, head)
    if joined is None:
        return None
    texts = {name: _decoded(joined, name) for name in CANDIDATES}
    shares = {name: _known(text) for name, text in texts.items() if text is not None}
    best = max(shares, key=lambda name: shares[name], default=None)
    return best if best is not None and shares[best] > 0 else None


def foreign(data: bytes, head: int) -> bytes | None:
    """The first lines of a text that are beyond ASCII; None where it is UTF-8 or wider."""
    start = data[:head]
    if data.isascii() or b"\0" in start:
        return None
    lines = [x for x in start.split(b"\n")[:-1] or [start] if not x.isascii()][:SOME]
    joined = b"\n".join(lines)
    return joined if lines and _decoded(joined, "utf-8") is None else None


def _decoded(data: bytes, encoding: str) -> str | None:
    try:
        return data.decode(encoding)
    except UnicodeDecodeError:
        return None


def _known(text: str) -> float:
    """Share of the characters beyond ASCII that are in words of headings or are signs of units."""
    beyond = _beyond(text)
    signs = sum(text.count(s) for s in _SIGNS)
    for sign in _SIGNS:
        text = text.replace(sign, " ")
    told = 0.0
    for word in re.findall(r"[^\W\d_]+", text):
        if word.isascii():
            continue
        plain = lexicon.without_accents(word.lower())
        left = 0 if plain in _WORDS else _beyond(_FOREIGN.sub("", plain))
        told += _beyond(word) * (1.0 if plain in _WORDS else 1.0 - left / max(_beyond(plain), 1))
        if plain.isascii() and plain not in _WORDS:
            told -= _beyond(word)
    return (signs + told) / beyond if beyond else 0.0


def _beyond(text: str) -> int:
    return sum(not c.isascii() for c in text)
