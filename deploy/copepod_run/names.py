"""Names that people read and that stay apart: of swept keys, of folders, of places in a page."""

import hashlib
import itertools
import re
from collections import Counter
from collections.abc import Sequence

_LONGEST = 120  # bytes of a folder's name; file systems take 255, and suffixes are added


def short_keys(keys: Sequence[str]) -> dict[str, str]:
    """The shortest ending of each key path that no other key has: «amplitude_N», «arms.1.drive.signal.lag_deg»."""
    shortened = {}
    for key in keys:
        parts = key.split(".")
        endings = (".".join(parts[start:]) for start in reversed(range(len(parts))) if not parts[start].isdigit())
        others = [f".{other}" for other in keys if other != key]
        shortened[key] = next((end for end in endings if not any(o.endswith(f".{end}") for o in others)), key)
    return shortened


def as_word(text: str) -> str:
    """The text as it may stand in names of files: what may have a meaning in paths becomes an underscore."""
    return re.sub(r"[^\w.+=-]+", "_", text)


def distinct_folders(names: Sequence[str], identities: Sequence[str], taken: Sequence[str] = ()) -> list[str]:
    """Names of folders that differ from each other and from those `taken`, even where case does not count. Those that
    would not, or that are too long, end with digits of the digest of their identity: no name depends on the order."""
    words = [as_word(name).strip("_") for name in names]
    times = Counter(word.casefold() for word in [*words, *taken])
    found = []
    for word, identity in zip(words, identities):
        if times[word.casefold()] > 1 or len(word.encode()) > _LONGEST:
            start = word.encode()[: _LONGEST - 9].decode(errors="ignore")
            word = f"{start}-{hashlib.sha256(identity.encode()).hexdigest()[:8]}"
        found.append(word)
    return found


def distinct_words(names: Sequence[str]) -> list[str]:
    """A word of ASCII letters, digits, dashes and underscores for each name, no two alike even where case does not
    count: for anchors of a page and the files beside it."""
    words: dict[str, str] = {}  # by what they are where case does not count
    for name in names:
        word = re.sub(r"[^A-Za-z0-9_-]+", "_", name).strip("_") or "run"
        numbered = itertools.chain([word], (f"{word}_{number}" for number in itertools.count(2)))
        unique = next(candidate for candidate in numbered if candidate.casefold() not in words)
        words[unique.casefold()] = unique
    return list(words.values())


_UNITS = {
    **{unit: unit for unit in ("m", "s", "N", "kg", "Pa", "W", "J", "Hz", "rad", "steps", "cells")},
    **{"deg": "°", "step": "step", "cell": "cell", "cycle": "cycle"},
}
_POWERS = {"": "", "2": "²", "3": "³"}
_OF_THREE = {"anchor", "axis", "center", "direction", "domain", "force", "gravity", "position", "velocity"}


def quantity_of(key: str) -> tuple[str, str]:
    """What a key names and its unit: («phase lag», «rad») of phase_lag_rad, («x of the center», «m») of center_m.0.

    Other positions in a list stay with the name; a key without a unit has an empty one.
    """
    ending = re.search(r"((?:\.\d+)*)$", key)
    position = ending[1] if ending else ""
    words = key.removesuffix(position).split("_")
    length, unit = next(((n, unit) for n in range(1, len(words)) if (unit := _unit_of(words[n:]))), (len(words), ""))
    name = " ".join(words[:length])
    if re.split(r"[. ]", name)[-1] in _OF_THREE and position in (".0", ".1", ".2"):
        return f"{'xyz'[int(position[1:])]} of the {name}", unit
    return name + position.replace(".", " "), unit


def _unit_of(words: Sequence[str]) -> str:
    """«N s/m» of N, s, per, m; empty if these are not units."""
    above, _, below = " ".join(words).partition(" per ")
    sides = []
    for side in (above, below):
        found = [re.fullmatch(r"([A-Za-z]+)([23]?)", word) for word in side.split()]
        if not all(match and match[1] in _UNITS for match in found):
            return ""
        sides.append(" ".join(_UNITS[match[1]] + _POWERS[match[2]] for match in found if match))
    return "/".join(side for side in sides if side)
