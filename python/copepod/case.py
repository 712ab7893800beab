"""A case as a dictionary whose keys are paths, as with `--set` on the command line."""

import copy
import difflib
import math
import re
from collections.abc import Iterator, Mapping, MutableMapping, Sequence
from pathlib import Path
from typing import Any

from copepod.errors import CaseError, required


class Case(MutableMapping[str, Any]):
    """The keys of a case file; docs and units of all keys are in configs/schema/case.schema.json.

        case = Case.load("swimmer.yaml")
        case["swimmers.0.stroke.amplitude_N"] = 2e-5     # the first swimmer; its name is possible, too
        case["bodies"] = [{"name": "ball", "shape": "sphere", ...}]
        case["output.fields.every_steps"] = 1000         # makes the sections that are missing

    Values are numbers, texts, lists and dictionaries; NumPy's become Python's. Whether they make sense is only known to
    `check` and `run`.
    """

    def __init__(self, values: Mapping[str, Any] | None = None) -> None:
        """@throws CaseError for a value that a case file cannot hold"""
        self._values: dict[str, Any] = _plain(values or {}, "")

    @classmethod
    def load(cls, path: str | Path) -> "Case":
        """The case in a YAML file, without its comments; aliases and merge keys are replaced by what they stand for.

        @throws CaseError if there is no such file, or it is not a YAML mapping that repeats no key
        """
        yaml = required("yaml")
        try:
            values = yaml.load(Path(path).read_text(), _loader(yaml))
        except OSError as problem:
            raise CaseError(f"{path} cannot be read ({problem.strerror}). Give the path of a YAML case file.") from None
        except (yaml.YAMLError, ValueError) as problem:
            raise CaseError(f"{path} is not YAML ({' '.join(str(problem).split())}). Correct that line.") from None
        if not isinstance(values, dict):
            raise CaseError(
                f"{path} is not a case (it must consist of «key: value» lines). Start it with «case: name»."
            )
        return cls(_with_absolute_files(values, Path(path).absolute().parent))

    def save(self, path: str | Path) -> None:
        """Writes a YAML file that `load` and the command read; names of files in it are absolute."""
        Path(path).write_text(self.text())

    def text(self) -> str:
        """The case as YAML; numbers read back to the same bits."""
        yaml = required("yaml")
        values = _with_absolute_files(self._values, Path.cwd())
        style = {"sort_keys": False, "default_flow_style": None, "allow_unicode": True}
        return str(yaml.dump(values, Dumper=_dumper(yaml), **style))

    def copy(self) -> "Case":
        """An independent copy."""
        return Case(self._values)

    def to_dict(self) -> dict[str, Any]:
        """The whole case in nested dictionaries and lists, independent of this one."""
        return copy.deepcopy(self._values)

    def __getitem__(self, path: str) -> Any:
        """A value; a section or list is the case's own, so that changing it changes the case.

        @throws KeyError with the keys that are there
        """
        found: Any = self._values
        parts = path.split(".")
        for number, part in enumerate(parts):
            found = found[_place(found, part, ".".join(parts[:number]))]
        return found

    def __setitem__(self, path: str, value: Any) -> None:
        """Sets a key, and makes the sections above it; the index behind the last item of a list appends to it.

        @throws KeyError if the path leads through something that is not a section or an item of a list
        """
        parts = path.split(".")
        value = _plain(value, path)
        found: Any = self._values
        for number, part in enumerate(parts):
            is_last = number == len(parts) - 1
            if isinstance(found, list) and part == str(len(found)):
                found.append(None if is_last else {})
            elif isinstance(found, dict) and (part not in found or found[part] is None) and not is_last:
                found[part] = [] if parts[number + 1] == "0" else {}
            place = part if isinstance(found, dict) else _place(found, part, ".".join(parts[:number]))
            if is_last:
                found[place] = value
            found = found[place]

    def __delitem__(self, path: str) -> None:
        parent, _, last = path.rpartition(".")
        section = self[parent] if parent else self._values
        del section[_place(section, last, parent)]

    def __iter__(self) -> Iterator[str]:
        return iter(self._values)

    def __len__(self) -> int:
        return len(self._values)

    def __repr__(self) -> str:
        return f"Case({self._values!r})"


def _place(parent: Any, part: str, where: str) -> Any:
    """Key or index of an item: a list's by its number or the `name` it carries. Raises KeyError; `where`: for it."""
    where = where or "the case"
    if isinstance(parent, dict):
        if part in parent:
            return part
        near = difflib.get_close_matches(part, parent, n=1)
        hint = f"Did you mean {near[0]}?" if near else f"It has {', '.join(parent)}."
        raise KeyError(f"«{part}» is not in {where}. {hint}")
    if not isinstance(parent, list):
        raise KeyError(f"«{part}» is not in {where} (it is {parent!r}). Set {where} to a section first.")
    names = [item.get("name") if isinstance(item, dict) else None for item in parent]
    named = names.index(part) if part in names else None
    place = int(part) if part.isdecimal() else named
    if part.isdecimal() and named not in (None, place):
        raise KeyError(f"«{part}» is ambiguous (the position of one item and the name of another). Rename that one.")
    if place is None or place >= len(parent):
        raise KeyError(f"«{part}» is not in {where} (a list of {len(parent)}). Use an index or the name of an item.")
    return place


def _plain(value: Any, path: str) -> Any:
    """A copy that consists of what YAML can hold."""
    if isinstance(value, Case):
        value = value._values
    if hasattr(value, "tolist"):  # NumPy's arrays and numbers
        value = value.tolist()
    if isinstance(value, Mapping):
        return {str(key): _plain(item, f"{path}.{key}".strip(".")) for key, item in value.items()}
    if isinstance(value, Sequence) and not isinstance(value, (str, bytes)):
        return [_plain(item, f"{path}.{number}".strip(".")) for number, item in enumerate(value)]
    if value is None or isinstance(value, (bool, int, float, str)):
        return value
    if isinstance(value, Path):
        return str(value)
    raise CaseError(f"{path} cannot be {value!r} (of {type(value)}). Use numbers, texts, lists and dictionaries.")


def _with_absolute_files(value: Any, folder: Path, key: Any = None) -> Any:
    """A copy; the tables of signals, which a case names relative to itself, are named from the root."""
    if isinstance(value, dict):
        return {name: _with_absolute_files(item, folder, name) for name, item in value.items()}
    if isinstance(value, list):
        return [_with_absolute_files(item, folder) for item in value]
    return str(folder / value) if key == "file" and isinstance(value, str) else value


# YAML 1.2, as the coupler reads it: PyYAML's own rules take 1e-6 for a text and «no» for a truth value.
_SCALARS = (
    ("tag:yaml.org,2002:bool", r"true|True|TRUE|false|False|FALSE", "tTfF"),
    ("tag:yaml.org,2002:int", r"[-+]?[0-9]+", "-+0123456789"),
    ("tag:yaml.org,2002:float", r"[-+]?(?:\.[0-9]+|[0-9]+(?:\.[0-9]*)?)(?:[eE][-+]?[0-9]+)?", "-+.0123456789"),
    ("tag:yaml.org,2002:null", r"~|null|Null|NULL|", ["~", "n", "N", ""]),
    ("tag:yaml.org,2002:merge", r"<<", "<"),
)


def _with_rules(base: Any) -> Any:
    """A loader or dumper with these rules."""
    kind: Any = type("Rules", (base,), {"yaml_implicit_resolvers": {}})
    for tag, pattern, first in _SCALARS:
        kind.add_implicit_resolver(tag, re.compile(rf"(?:{pattern})\Z"), list(first))
    return kind


def _loader(yaml: Any) -> Any:
    """Loader that refuses repeated keys."""

    def mapping(loader: Any, node: Any) -> Any:
        keys = [key.value for key, _ in node.value]
        for key in keys:
            if key != "<<" and keys.count(key) > 1:
                raise ValueError(f"line {node.start_mark.line + 1}: key «{key}» appears twice")
        loader.flatten_mapping(node)
        return loader.construct_mapping(node, deep=True)

    rules = _with_rules(yaml.SafeLoader)
    rules.add_constructor("tag:yaml.org,2002:map", mapping)
    rules.add_constructor("tag:yaml.org,2002:int", lambda loader, node: int(node.value))
    rules.add_constructor("tag:yaml.org,2002:float", lambda loader, node: _float(node))
    return rules


def _float(node: Any) -> float:
    """Refuses what is beyond the range of numbers, as the coupler does."""
    value = float(node.value)
    if math.isinf(value) or (value == 0.0 and re.search("[1-9]", re.split("[eE]", node.value)[0])):
        raise ValueError(f"line {node.start_mark.line + 1}: {node.value} is beyond the range of numbers")
    return value


def _dumper(yaml: Any) -> Any:
    """Dumper that writes equal lists twice instead of as aliases."""
    rules = _with_rules(yaml.SafeDumper)
    rules.ignore_aliases = lambda dumper, value: True
    rules.add_representer(float, lambda dumper, value: dumper.represent_scalar(_SCALARS[2][0], repr(value)))
    return rules
