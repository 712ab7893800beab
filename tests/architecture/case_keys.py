#!/usr/bin/python3
"""The table of all keys of a case, docs/case_keys.md, from the schema that the coupler prints.

    tests/architecture/case_keys.py --write
"""

import json
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs/case_keys.md"
HEAD = """# Keys of a case

Every key of a case file, from [`configs/schema/case.schema.json`](../configs/schema/case.schema.json): its values, its
default, and its meaning. `[]` stands for an item of a list, `*` for a name of your own. Keys carry their units.

Written by `tests/architecture/case_keys.py --write`.
"""


def page() -> str:
    schema = json.loads((ROOT / "configs/schema/case.schema.json").read_text())
    parts, listed = [HEAD], {}
    for name, section in schema["properties"].items():
        rows = [_row(name, section, name in schema["required"]), *_rows(section, name, listed)]
        parts.append(
            f"\n## {name}\n\n| key | values | default | meaning |\n|---|---|---|---|\n" + "\n".join(rows) + "\n"
        )
    return "".join(parts)


def _rows(node: dict, path: str, listed: dict[str, str]) -> list[str]:
    """Of all keys below a node; where a section is like one that was listed, its path."""
    rows = []
    for form in node.get("anyOf", []):
        rows += _rows(form, path, listed)
    if "items" in node:
        rows += _rows(node["items"], f"{path}.[]", listed)
    if isinstance(node.get("additionalProperties"), dict):
        rows += _rows(node["additionalProperties"], f"{path}.*", listed)
    first = listed.setdefault(json.dumps(node.get("properties")), path)
    if first != path and "properties" in node:
        return [*rows, f"| `{path}.…` | | | as `{first}.…` |"]
    for key, child in node.get("properties", {}).items():
        rows += [_row(f"{path}.{key}", child, key in node.get("required", []))]
        rows += _rows(child, f"{path}.{key}", listed)
    return rows


def _row(path: str, node: dict, is_required: bool) -> str:
    default = "required" if is_required else _text(node["default"]) if "default" in node else ""
    return f"| `{path}` | {_values(node)} | {default} | {node['description'].replace('|', '¦')} |"


def _values(node: dict) -> str:
    """«number > 0», «trt, bgk», «list of 3 numbers», …"""
    if "anyOf" in node:
        return " or ".join(dict.fromkeys(_values(form) for form in node["anyOf"] if _values(form)))
    if "enum" in node or "const" in node:
        return ", ".join(f"`{word}`" for word in node.get("enum", [node.get("const")]))
    if node.get("type") == "array":
        size = f" of {node['minItems']}" if node.get("minItems") == node.get("maxItems") and "minItems" in node else ""
        return f"list{size}: {_values(node['items'])}" if _values(node.get("items", {})) else f"list{size}"
    bounds = {"exclusiveMinimum": ">", "minimum": "≥", "maximum": "≤"}
    limits = " and ".join(f"{sign} {_text(node[key])}" for key, sign in bounds.items() if key in node)
    names = {"object": "section", "string": "text", "boolean": "`true`, `false`"}
    kind = str(node.get("type", ""))
    return f"{names.get(kind, kind)} {limits}".strip()


def _text(value: object) -> str:
    return f"`{json.dumps(value)}`" if isinstance(value, (list, str, bool)) else f"{value:g}"


if __name__ == "__main__":
    if "--write" in sys.argv:
        PAGE.write_text(page())
    elif PAGE.read_text() != page():
        sys.exit(f"{PAGE} differs from the schema. Write it again: tests/architecture/case_keys.py --write")
