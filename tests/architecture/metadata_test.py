#!/usr/bin/python3
"""Version, licence and title are the same wherever the project states them, and what machines read of it is complete.

CMakeLists.txt has the version; the build, both Python packages and the command take it from there or repeat it.
"""

import importlib.util
import json
import re
import shutil
import subprocess
import tempfile
import tomllib
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
LICENCES = {"BSD 3-Clause License": "BSD-3-Clause"}  # first line of LICENSE: its SPDX identifier
FILES = ("CHANGELOG.md", "CITATION.cff", "CMakeLists.txt", "LICENSE", "README.md", "codemeta.json", "pyproject.toml")

# file: what it must take from the build instead of a number of its own
FROM_THE_BUILD = {
    "proto/python/pyproject.toml.in": 'version = "@PROJECT_VERSION@"',
    "coupler/run/build_info.cpp.in": '{"@VERSION@"',
    "coupler/CMakeLists.txt": "-DVERSION=${PROJECT_VERSION} ",
    "fluid_service/CMakeLists.txt": 'COPEPOD_VERSION="${PROJECT_VERSION}"',
    "body_service/CMakeLists.txt": 'COPEPOD_VERSION="${PROJECT_VERSION}"',
    "body_service/bullet/CMakeLists.txt": 'COPEPOD_VERSION="${PROJECT_VERSION}"',
    "body_service/mujoco/CMakeLists.txt": 'COPEPOD_VERSION="${PROJECT_VERSION}"',
    "in_process/CMakeLists.txt": 'COPEPOD_VERSION="${PROJECT_VERSION}"',
    "proto/cmake/CMakeLists.txt": "VERSION ${PROJECT_VERSION} ",
}

# key: pattern of its value, "" for a list of sections; required by the schemas of CFF 1.2.0 and CodeMeta 2.0, or by us
CITATION = {
    "cff-version": r"1\.2\.0",
    "message": r".+",
    "type": r"software|dataset",
    "title": r".+",
    "authors": "",
    "version": r"\d+\.\d+\.\d+",
    "date-released": r"\d{4}-\d\d-\d\d",
    "license": r"[\w.-]+",
    "abstract": r".+",
    "references": "",
}
REFERENCE = {"type": r"article", "title": r".+", "authors": "", "journal": r".+", "url": r"https://\S+"}
CITATION_OPTIONAL = {"keywords"}
REFERENCE_OPTIONAL = {"identifiers"}
PERSON = {"family-names": r".+", "given-names": r".+"}
ENTITY = {"name": r".+"}
CODEMETA = {
    "@context": r"https://doi\.org/10\.5063/schema/codemeta-2\.0",
    "@type": r"SoftwareSourceCode",
    "name": r".+",
    "description": r".+",
    "version": r"\d+\.\d+\.\d+",
    "datePublished": r"\d{4}-\d\d-\d\d",
    "license": r"https://spdx\.org/licenses/[\w.-]+",
    "author": "",
}
# terms of CodeMeta 2.0 (https://codemeta.github.io/terms) that the file may use beside those
CODEMETA_OPTIONAL = {
    *("buildInstructions", "codeRepository", "contIntegration", "contributor", "dateCreated", "dateModified"),
    *("developmentStatus", "downloadUrl", "funder", "identifier", "issueTracker", "keywords", "maintainer"),
    *("operatingSystem", "programmingLanguage", "readme", "referencePublication", "releaseNotes", "relatedLink"),
    *("softwareHelp", "softwareRequirements", "url"),
}


def problems_of_section(where, section, required, optional=frozenset()):
    """What keeps a section from having every key of `required` and no other than those and `optional`."""
    for key, pattern in required.items():
        value = section.get(key)
        if pattern == "":
            if not (isinstance(value, list) and value and all(isinstance(entry, dict) for entry in value)):
                yield f"{where}: {key} is not a list of sections"
        elif not isinstance(value, str) or not re.fullmatch(pattern, value):
            yield f"{where}: {key} is {value!r}, not {pattern}"
    for key in sorted(set(section) - set(required) - set(optional)):
        yield f"{where}: {key} is not one of its keys"


def problems_of_citation(citation):
    yield from problems_of_section("CITATION.cff", citation, CITATION, CITATION_OPTIONAL)
    for author in citation.get("authors") or ():
        yield from problems_of_section("CITATION.cff: authors", author, ENTITY if "name" in author else PERSON)
    for reference in citation.get("references") or ():
        yield from problems_of_section("CITATION.cff: references", reference, REFERENCE, REFERENCE_OPTIONAL)
        for author in reference.get("authors") or ():
            yield from problems_of_section("CITATION.cff: references: authors", author, PERSON)


def names_of_authors(citation):
    """As «Given Family», of software and of its first reference."""
    people = citation["authors"] + citation["references"][0]["authors"]
    return [person.get("name") or f"{person['given-names']} {person['family-names']}" for person in people]


def names_of_codemeta(codemeta):
    people = codemeta["author"] + codemeta["referencePublication"]["author"]
    return [person.get("name") or f"{person['givenName']} {person['familyName']}" for person in people]


def differences(root):
    """One line for each figure that two files of the tree `root` state differently."""
    import yaml

    text = {name: (root / name).read_text(encoding="utf-8") for name in FILES}
    project, version = re.search(r"^project\((\w+) VERSION ([\d.]+)", text["CMakeLists.txt"], re.MULTILINE).groups()
    released, date = re.search(r"^## \[([\d.]+)\] - (\S+)$", text["CHANGELOG.md"], re.MULTILINE).groups()
    licence = LICENCES.get(text["LICENSE"].partition("\n")[0], "unknown")
    title = re.match(r"# (.+)\n", text["README.md"])[1]
    package = tomllib.loads(text["pyproject.toml"])["project"]
    citation = yaml.load(text["CITATION.cff"], yaml.BaseLoader)  # every value as the text that it is
    codemeta = json.loads(text["codemeta.json"])

    found = [
        *problems_of_citation(citation),
        *problems_of_section("codemeta.json", codemeta, CODEMETA, CODEMETA_OPTIONAL),
    ]
    if found:
        return found
    same = [
        ("title", title, {"CITATION.cff": citation["title"], "codemeta.json": codemeta["name"]}),
        ("name", title.lower(), {"CMakeLists.txt": project, "pyproject.toml": package["name"]}),
        ("version", version, {"pyproject.toml": package["version"], "CITATION.cff": citation["version"]}),
        ("version", version, {"codemeta.json": codemeta["version"], "CHANGELOG.md": released}),
        ("date", date, {"CITATION.cff": citation["date-released"], "codemeta.json": codemeta["datePublished"]}),
        ("licence", licence, {"pyproject.toml": package["license"]["text"], "CITATION.cff": citation["license"]}),
        ("licence", licence, {"codemeta.json": codemeta["license"].rpartition("/")[2]}),
        ("abstract", citation["abstract"], {"codemeta.json": codemeta["description"]}),
        ("keywords", citation["keywords"], {"codemeta.json": codemeta["keywords"]}),
        ("reference", citation["references"][0]["title"], {"codemeta.json": codemeta["referencePublication"]["name"]}),
        ("authors", names_of_authors(citation), {"codemeta.json": names_of_codemeta(codemeta)}),
    ]
    if not re.search(rf"^{licence}, see \[LICENSE\]", text["README.md"], re.MULTILINE):
        found.append(f"licence: README.md does not end with {licence}")
    return found + [
        f"{what}: {name} has {value!r}, not {expected!r}"
        for what, expected, values in same
        for name, value in values.items()
        if value != expected
    ]


@unittest.skipIf(importlib.util.find_spec("yaml") is None, "PyYAML is not installed")
class Metadata(unittest.TestCase):
    def test_is_the_same_in_every_file(self):
        self.assertEqual(differences(ROOT), [])

    def test_every_difference_is_found(self):
        for name, old, new, message in (
            ("CMakeLists.txt", r"VERSION \d+\.", "VERSION 77.", "version"),
            ("CMakeLists.txt", r"project\(copepod", "project(daphnia", "name"),
            ("CHANGELOG.md", r"(?m)^## \[\d+", "## [77", "version"),
            ("pyproject.toml", r'version = "', 'version = "7', "version"),
            ("pyproject.toml", r"BSD-3-Clause", "MIT", "licence"),
            ("pyproject.toml", r'name = "copepod"', 'name = "daphnia"', "name"),
            ("CITATION.cff", r"(?m)^version: ", "version: 7", "version"),
            ("CITATION.cff", r"(?m)^license: .*", "license: MIT", "licence"),
            ("CITATION.cff", r"(?m)^title: .*", "title: Daphnia", "title"),
            ("CITATION.cff", r"(?m)^date-released: 2", "date-released: 3", "date"),
            ("CITATION.cff", r"(?m)^message: .*\n", "", "message is None"),
            ("CITATION.cff", r"(?m)^  - name: .*\n", "", "authors is not a list"),
            ("CITATION.cff", r"family-names", "surname", "surname is not one of its keys"),
            ("CITATION.cff", r"cff-version: 1.2.0", "cff-version: 1.3.0", "cff-version"),
            ("CITATION.cff", r"Kristina", "Christina", "authors"),
            ("codemeta.json", r'"version": "', '"version": "7', "version"),
            ("codemeta.json", r"BSD-3-Clause", "MIT", "licence"),
            ("codemeta.json", r'"Copepod"', '"Daphnia"', "title"),
            ("codemeta.json", r'"@type": "SoftwareSourceCode",', "", "@type is None"),
            ("codemeta.json", r'"readme"', '"readMe"', "readMe is not one of its keys"),
            ("README.md", r"BSD-3-Clause, see", "MIT, see", "licence"),
            ("LICENSE", r"BSD 3-Clause", "MIT", "licence"),
        ):
            with self.subTest(file=name, change=new), tempfile.TemporaryDirectory() as folder:
                for copied in FILES:
                    shutil.copy(ROOT / copied, folder)
                path = Path(folder, name)
                changed, count = re.subn(old, new, path.read_text(encoding="utf-8"))
                self.assertGreater(count, 0, "there is nothing to change")
                path.write_text(changed, encoding="utf-8")
                self.assertIn(message, "\n".join(differences(Path(folder))))


class Version(unittest.TestCase):
    def test_of_programs_and_kit_is_that_of_the_build(self):
        for name, expected in FROM_THE_BUILD.items():
            with self.subTest(file=name):
                self.assertIn(expected, (ROOT / name).read_text(encoding="utf-8"))

    def test_of_every_program_is_listed_here(self):
        paths = [path for path in ROOT.glob("*/**/CMakeLists.txt") if "build" not in path.relative_to(ROOT).parts[0]]
        users = {path.relative_to(ROOT).as_posix() for path in paths if "PROJECT_VERSION" in path.read_text()}
        self.assertLessEqual(users, set(FROM_THE_BUILD))

    def test_is_what_the_command_prints(self):
        version = re.search(r"^project\(\w+ VERSION ([\d.]+)", (ROOT / "CMakeLists.txt").read_text(), re.MULTILINE)[1]
        command = [ROOT / "deploy/copepod", "--version"]
        printed = subprocess.run(command, capture_output=True, text=True, check=True).stdout
        self.assertEqual(printed, f"copepod {version}\n")


if __name__ == "__main__":
    unittest.main()
