#!/usr/bin/python3
"""Measures the structure of one or more checkouts and prints a Markdown table, one column per checkout.

    tests/architecture/structure.py [NAME=]CHECKOUT … [--details]

Definitions, the same for every checkout:
  files, lines    sources tracked by git or lying in the tree: C, C++, Python, shell, CMake, Protobuf, JavaScript;
                  code lines leave out blank lines and comments (docstrings too)
  folder cycles   groups of C++ folders that include each other, or of Python packages that import each other
  module cycles   groups of Python modules that import each other; imports inside functions count
  singletons      C++: variables that are not constant at namespace scope, in a function (`static`) or in a class
                  (`static`); Python: module variables that a function rebinds (`global`) or changes (`append`, `[…] =`)
  trips           the files a reader opens to follow one course of events, listed by hand in trips/ with the names
                  that are read in each; a list counts only if every file exists and contains its names
  length          of functions (signature to closing brace) and files of C++ and Python without tests; median and
                  ninth decile
"""

import argparse
import ast
import re
import statistics
from collections import defaultdict
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

TRIPS = Path(__file__).resolve().parent / "trips"
COMPONENTS = ("proto", "coupler", "fluid_service", "body_service", "in_process")
PYTHON_ROOTS = ("deploy", "proto/python")
TESTS = ("tests", ".ci")
CPP = (".cpp", ".hpp", ".h", ".c", ".cu", ".cuh")
SOURCES = (*CPP, ".py", ".sh", ".cmake", ".proto", ".js")
SKIPPED = ("build", ".git", "__pycache__", "node_modules", "shared")

CPP_NOISE = re.compile(r'//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])+\'', re.DOTALL)
INCLUDE = re.compile(r'^\s*#\s*include\s*"([^"]+)"', re.MULTILINE)
NOT_A_FUNCTION = r"(?:if|for|while|switch|catch|return|sizeof|decltype|alignas|static_assert|constexpr)"
FUNCTION = re.compile(
    rf"\b(?!{NOT_A_FUNCTION}\b)[\w~]+(?:<[^<>;{{}}]*>)?\s*\((?:[^()]|\([^()]*\))*\)"
    r"(?:\s|\bconst\b|\bnoexcept\b|\boverride\b|\bfinal\b|->\s*[\w:<>,&* ]+|"
    r":\s*(?:[\w:<>]+\s*[({][^;]*?[)}]\s*,?\s*)+)*\{"
)
NO_VARIABLE = (
    r"const|constexpr|constinit|using|typedef|return|extern|class|struct|enum|friend|operator|namespace|concept"
)
CONSTANT = re.compile(rf"\b(?:{NO_VARIABLE})\b")
NAMESPACE_VARIABLE = re.compile(
    r"^(?:inline |static |thread_local )*[\w:]+(?:<[^;=()]*>)?[&*]? (\w+)(?:\[\w*\])?(?: = [^;]*|\{[^;]*\})?;$",
    re.MULTILINE,
)
STATIC_VARIABLE = re.compile(
    r"^[ \t]+(?:inline |thread_local )*static (?:inline |thread_local )*([^;=({]*)[;={]", re.MULTILINE
)


Edges = dict[tuple[str, str], list[str]]


class Source(NamedTuple):
    path: str
    text: str

    @property
    def is_cpp(self) -> bool:
        return self.path.endswith(CPP)

    @property
    def is_python(self) -> bool:
        return self.path.endswith(".py") or self.text.startswith("#!/usr/bin/python3")

    @property
    def is_test(self) -> bool:
        return self.path.startswith(tuple(f"{folder}/" for folder in TESTS))


def sources(root: Path) -> list[Source]:
    """Every source below `root`, scripts without an ending included."""
    found = []
    for path in sorted(root.rglob("*")):
        inside = path.relative_to(root)
        if not path.is_file() or any(part in SKIPPED or part.startswith("build-") for part in inside.parts):
            continue
        if path.suffix not in (*SOURCES, "") and path.name != "CMakeLists.txt":
            continue
        try:
            text = path.read_text(encoding="utf-8")
        except UnicodeDecodeError:
            continue
        if path.suffix or text.startswith("#!"):
            found.append(Source(inside.as_posix(), text))
    return found


def without_noise(text: str) -> str:
    """C++ without comments and the contents of strings; lines stay where they are."""

    def blank(match: re.Match[str]) -> str:
        return '""' if match[0][0] in "\"'" else "\n" * match[0].count("\n")

    return CPP_NOISE.sub(blank, text)


def code_lines(source: Source) -> int:
    if source.is_cpp or source.path.endswith((".proto", ".js")):
        text = without_noise(source.text)
    else:
        text = re.sub(r"^\s*#.*$", "", source.text, flags=re.MULTILINE)
    lines = sum(1 for line in text.splitlines() if line.strip())
    if source.is_python:
        lines -= sum(docstring_lines(node) for node in ast.walk(ast.parse(source.text)))
    return lines


def docstring_lines(node: ast.AST) -> int:
    """Lines of the docstring of a module, class or function that are not blank."""
    if not isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef)):
        return 0
    return sum(1 for line in (ast.get_docstring(node) or "").splitlines() if line.strip())


def cycles(edges: dict[str, set[str]]) -> list[list[str]]:
    """Groups of nodes that reach each other (Tarjan 1972), each sorted."""
    index: dict[str, int] = {}
    low: dict[str, int] = {}
    stack: list[str] = []
    groups = []

    def visit(node: str) -> None:
        index[node] = low[node] = len(index)
        stack.append(node)
        for other in sorted(edges.get(node, ())):
            if other not in index:
                visit(other)
            if other in stack:
                low[node] = min(low[node], low[other])
        if low[node] != index[node]:
            return
        group = stack[stack.index(node) :]
        del stack[stack.index(node) :]
        if len(group) > 1:
            groups.append(sorted(group))

    for node in sorted(edges):
        if node not in index:
            visit(node)
    return groups


def include_edges(all_sources: list[Source]) -> Edges:
    """(folder, included folder) -> the files that include; C++ of the components, tests left out."""
    paths = {source.path for source in all_sources if source.is_cpp}
    edges: Edges = defaultdict(list)
    for source in all_sources:
        component = source.path.split("/")[0]
        if not source.is_cpp or component not in COMPONENTS:
            continue
        folder = str(Path(source.path).parent)
        for header in INCLUDE.findall(source.text):
            for base in (folder, component, *COMPONENTS):
                if f"{base}/{header}" in paths:
                    target = str(Path(f"{base}/{header}").parent)
                    if target != folder:
                        edges[folder, target].append(f"{source.path} -> {header}")
                    break
    return edges


def import_edges(all_sources: list[Source]) -> Edges:
    """(module, imported module) -> where, for the packages below the Python roots."""
    modules = {}
    for source in all_sources:
        for root in PYTHON_ROOTS:
            if source.path.startswith(f"{root}/") and source.path.endswith(".py"):
                name = source.path.removeprefix(f"{root}/").removesuffix(".py").replace("/", ".")
                modules[name.removesuffix(".__init__")] = source
    edges: Edges = defaultdict(list)
    for name, source in modules.items():
        package = name if source.path.endswith("__init__.py") else name.rpartition(".")[0]
        for node in ast.walk(ast.parse(source.text)):
            for target in imported(node, package, modules):
                if target != name:
                    edges[name, target].append(f"{source.path}:{getattr(node, 'lineno', 0)}")
    return edges


def imported(node: ast.AST, package: str, modules: dict[str, Source]) -> set[str]:
    """Modules of ours that one import statement names."""
    if isinstance(node, ast.Import):
        return {alias.name for alias in node.names if alias.name in modules}
    if not isinstance(node, ast.ImportFrom):
        return set()
    base = node.module or ""
    if node.level:
        parts = package.split(".")
        base = ".".join([*parts[: len(parts) - node.level + 1], *([base] if base else [])])
    inner = {f"{base}.{alias.name}" for alias in node.names if f"{base}.{alias.name}" in modules}
    whole = {base} if base in modules and len(inner) < len(node.names) else set()
    return inner | whole


def grouped(edges: Edges, depth: int | None = None) -> dict[str, set[str]]:
    """Adjacency of the nodes, or of their first `depth` parts."""
    result: dict[str, set[str]] = defaultdict(set)
    for one, other in edges:
        a, b = (one, other) if depth is None else (".".join(name.split(".")[:depth]) for name in (one, other))
        if a != b:
            result[a].add(b)
    return result


def singletons(all_sources: list[Source]) -> list[str]:
    found = []
    for source in all_sources:
        if source.is_test:
            continue
        if source.is_cpp:
            text = without_noise(source.text)
            names = [m[0].strip() for m in STATIC_VARIABLE.finditer(text) if not CONSTANT.search(m[1])]
            names += [m[0] for m in NAMESPACE_VARIABLE.finditer(text) if not CONSTANT.search(m[0].split("=")[0])]
            found += [f"{source.path}: {name}" for name in names]
        elif source.is_python:
            found += [f"{source.path}: {name}" for name in changed_module_variables(ast.parse(source.text))]
    return found


def changed_module_variables(module: ast.Module) -> list[str]:
    """Names bound at module level that a function rebinds or changes in place."""
    changing = {"append", "add", "update", "setdefault", "extend", "pop", "clear", "insert", "remove"}
    bound = {
        target.id
        for node in module.body
        if isinstance(node, (ast.Assign, ast.AnnAssign))
        for target in (node.targets if isinstance(node, ast.Assign) else [node.target])
        if isinstance(target, ast.Name)
    }
    changed = set()
    for function in (node for node in ast.walk(module) if isinstance(node, ast.FunctionDef)):
        own = {arg.arg for arg in function.args.args} | {
            node.id for node in ast.walk(function) if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)
        }
        for node in ast.walk(function):
            if isinstance(node, ast.Global):
                changed |= set(node.names)
            inner = None
            if isinstance(node, ast.Subscript) and isinstance(node.ctx, ast.Store):
                inner = node.value
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr in changing:
                inner = node.func.value
            if isinstance(inner, ast.Name) and inner.id in bound - own:
                changed.add(inner.id)
    return sorted(changed)


def function_lengths(source: Source) -> list[int]:
    if source.is_python:
        return [
            (node.end_lineno or node.lineno) - node.lineno + 1
            for node in ast.walk(ast.parse(source.text))
            if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef))
        ]
    if not source.is_cpp:
        return []
    text = re.sub(r"^\s*#.*$", "", without_noise(source.text), flags=re.MULTILINE)
    lengths = []
    position = 0
    while match := FUNCTION.search(text, position):
        depth, end = 1, match.end()
        while depth and end < len(text):
            depth += {"{": 1, "}": -1}.get(text[end], 0)
            end += 1
        lengths.append(text.count("\n", match.start(), end) + 1)
        position = end
    return lengths


def trip_problems(root: Path, trip: Path) -> list[str]:
    """What does not fit a checkout in the list of one trip."""
    problems = []
    for path, names in stops(trip):
        file = root / path
        if not file.is_file():
            problems.append(f"{trip.name}: {path} does not exist")
            continue
        text = file.read_text(encoding="utf-8")
        problems += [
            f"{trip.name}: {path} does not contain {name}" for name in names if not re.search(rf"\b{name}\b", text)
        ]
    return problems


def stops(trip: Path) -> list[tuple[str, list[str]]]:
    """(file, names read there) in the order of the list."""
    lines = trip.read_text(encoding="utf-8").splitlines()
    rows = [line.split(":", 1) for line in lines if line.strip() and not line.startswith("#")]
    return [(path.strip(), names.split()) for path, names in rows]


def trips_of(root: Path) -> list[tuple[str, str]]:
    """(trip, number of files) from the set of lists that fits the checkout; "?" where none does."""
    result = []
    for name in sorted({trip.name for trip in TRIPS.rglob("*.txt")}):
        fitting = [trip for trip in sorted(TRIPS.rglob(name)) if not trip_problems(root, trip)]
        result.append(
            (
                name.removesuffix(".txt").replace("_", " "),
                str(len({path for path, _ in stops(fitting[0])})) if fitting else "?",
            )
        )
    return result


def ninth_decile(numbers: list[int]) -> int:
    return sorted(numbers)[len(numbers) * 9 // 10]


def measure(root: Path, details: bool) -> dict[str, str]:
    """Rows of the table: label -> value."""
    everything = sources(root)
    productive = [source for source in everything if not source.is_test]
    rows = {}

    def count(label: str, part: list[Source]) -> None:
        lines = sum(len(source.text.splitlines()) for source in part)
        code = sum(code_lines(source) for source in part)
        rows[label] = f"{len(part)} files, {lines} lines, {code} of code"

    for folder in (*COMPONENTS, "deploy", "tests"):
        count(f"`{folder}/`", [source for source in everything if source.path.startswith(f"{folder}/")])
    count("all without tests", productive)
    count("all", everything)

    includes, imports = include_edges(everything), import_edges(everything)
    lists = {
        "folder cycles, C++": cycles(grouped(includes)),
        "package cycles, Python": cycles(grouped(imports, 1)),
        "module cycles, Python": cycles(grouped(imports)),
        "mutable singletons": singletons(everything),
    }
    for label, found in lists.items():
        rows[label] = str(len(found))
        if details:
            print(f"## {label}", *found, sep="\n  ")
    rows["folders in a cycle"] = str(sum(len(group) for group in lists["folder cycles, C++"]))
    rows["modules in a cycle"] = str(sum(len(group) for group in lists["module cycles, Python"]))
    for trip, number in trips_of(root):
        rows[f"trip: {trip}"] = number

    lengths = [length for source in productive for length in function_lengths(source)]
    files = [len(source.text.splitlines()) for source in productive if source.is_cpp or source.is_python]
    rows["functions: median, ninth decile"] = f"{statistics.median(lengths):.0f}, {ninth_decile(lengths)} lines"
    rows["source files: median, ninth decile"] = f"{statistics.median(files):.0f}, {ninth_decile(files)} lines"
    if details:
        print("## edges inside C++ folder cycles")
        print_edges(includes, lists["folder cycles, C++"], lambda name: name)
        print("## edges inside Python package cycles")
        print_edges(imports, lists["package cycles, Python"], lambda name: name.split(".")[0])
        print("## what does not fit in the list of each trip that fits best")
        for name in sorted({trip.name for trip in TRIPS.rglob("*.txt")}):
            print(*min((trip_problems(root, trip) for trip in TRIPS.rglob(name)), key=len), sep="\n")
    return rows


def print_edges(edges: Edges, groups: list[list[str]], place: Callable[[str], str]) -> None:
    for group in groups:
        for (one, other), where in sorted(edges.items()):
            if place(one) != place(other) and place(one) in group and place(other) in group:
                print(f"  {one} -> {other}:", *where, sep="\n      ")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("checkouts", nargs="+", metavar="[NAME=]CHECKOUT")
    parser.add_argument("--details", action="store_true", help="also print each cycle, singleton and misfit")
    options = parser.parse_args()
    named = [text.rpartition("=")[::2] for text in options.checkouts]
    columns = {name or Path(path).resolve().name: measure(Path(path), options.details) for name, path in named}
    print("| | " + " | ".join(columns) + " |\n|---" * 1 + "|---" * len(columns) + "|")
    for label in next(iter(columns.values())):
        print(f"| {label} | " + " | ".join(rows[label] for rows in columns.values()) + " |")


if __name__ == "__main__":
    main()
