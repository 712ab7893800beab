"""`copepod export`: a finished run as an RO-Crate 1.1, a folder that an archive takes and machines read.

https://w3id.org/ro/crate/1.1; the run is a CreateAction, as in the Process Run Crate profile.
"""

import hashlib
import json
import shutil
import tempfile
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from copepod_report.run_status import state_of
from copepod_run.errors import BadCase
from copepod_run.names import quantity_of
from copepod_run.run_directory import make_folder, read_object

METADATA = "ro-crate-metadata.json"
_SUMS = "sha256sums.txt"
_CONTEXT = "https://w3id.org/ro/crate/1.1"
_TERMS = {"sha256": "https://w3id.org/ro/terms/workflow-run#sha256"}  # beside those of the context
_PROFILE = "https://w3id.org/ro/wfrun/process/0.5"
# What an export holds of a run directory, and what it is. The rest is for resuming, or about the machine.
_CONTENT = {
    "case.yaml": (
        "the case with every default spelled out: `copepod run case.yaml` repeats the run",
        "application/yaml",
    ),
    "provenance.json": ("programs, versions, host, times and command line", "application/json"),
    "summary.json": ("figures and the digest of the final state", "application/json"),
    "trajectory.csv": ("position, orientation, velocities, loads and drive of every body over time", "text/csv"),
    "trajectory.npy": (
        "the same as an array of NumPy, a field of shape (bodies, components) each",
        "application/x-npy",
    ),
    "trajectory_names.txt": ("names of its bodies", "text/plain"),
    "obstacles.csv": ("loads on obstacles over time", "text/csv"),
    "obstacles.npy": ("the same as an array of NumPy, a field of shape (bodies, components) each", "application/x-npy"),
    "obstacles_names.txt": ("names of the obstacles", "text/plain"),
    "cycles.csv": ("velocity, rotation, arms and power of every swimmer in each cycle", "text/csv"),
    "bodies.pvd": ("surfaces of the bodies over time, for ParaView", "application/xml"),
    "bodies": ("the surfaces of each sample", ""),
    "fields.h5": ("flow: density, velocity and what else the case asks for", "application/x-hdf5"),
    "fields.xdmf": ("snapshots of the flow, for ParaView", "application/xml"),
    "fields_mean.xdmf": ("the mean flow, for ParaView", "application/xml"),
    "fields": ("the flow of each snapshot, and the mean", ""),
    "report": ("tables, plots and a 3-D view; open report.html", ""),
}


def export(directory: Path, folder: Path, author: str, license_of_data: str) -> Path:
    """Writes the crate of a run into a new folder, which is there when it is complete; the path of its description.

    @param license_of_data  a URL, or the identifier that SPDX gives a licence, as CC-BY-4.0
    Raises Stop(2) unless the folder is a finished run and the other one new.
    """
    state, reason = state_of(directory)
    if state != "finished" or not (directory / "summary.json").is_file():
        what = f"has not finished ({reason or state})" if (directory / "case.yaml").is_file() else "is not a run"
        raise BadCase(f"{directory} {what}. Give the directory of a finished run; one by one, those of a campaign.")
    if folder.exists():
        raise BadCase(f"{folder} exists (an export never replaces anything). Name a new folder with --out.")
    make_folder(folder.parent)
    with tempfile.TemporaryDirectory(prefix=f"{folder.name}.", dir=folder.parent) as beside:
        begun = Path(beside, "crate")
        begun.mkdir()
        for name in _CONTENT:
            source = directory / name
            if source.is_dir():
                shutil.copytree(source, begun / name)
            elif source.exists():
                shutil.copyfile(source, begun / name)
        _describe(begun, author, license_of_data)
        begun.rename(folder)
    return folder / METADATA


def _describe(folder: Path, author: str, license_of_data: str) -> None:
    """Adds checksums and the description to the files of a crate."""
    paths = sorted(path for path in folder.rglob("*") if path.is_file())
    sums = {path.relative_to(folder).as_posix(): _sha256(path) for path in paths}
    (folder / _SUMS).write_text("".join(f"{digest}  {name}\n" for name, digest in sums.items()))
    graph = _graph(folder, sums, author, license_of_data)
    (folder / METADATA).write_text(
        json.dumps({"@context": [f"{_CONTEXT}/context", _TERMS], "@graph": graph}, indent=2) + "\n"
    )


def _graph(folder: Path, sums: dict[str, str], author: str, license_of_data: str) -> list[dict[str, Any]]:
    """The entities of the description: crate, files, run, software and measured quantities."""
    provenance, summary = (read_object(folder / f"{name}.json") for name in ("provenance", "summary"))
    files = [_file(folder, name, sums) for name in _CONTENT if (folder / name).exists()]
    columns = [
        column for name in ("trajectory.csv", "trajectory.npy", "cycles.csv") for column in _columns(folder / name)
    ]
    digest = {"@id": "#digest", "@type": "PropertyValue", "name": "digest", "value": summary["digest"]}
    license_url = license_of_data if "://" in license_of_data else f"https://spdx.org/licenses/{license_of_data}"
    writer = {"@id": "#author", "@type": "Person", "name": author}
    crate = {
        "@id": "./",
        "@type": "Dataset",
        "name": f"Copepod run {summary['case']}",
        "description": f"A coupled simulation of a fluid and moving bodies, with Copepod {provenance['version']}. To "
        "repeat it: copepod run case.yaml; the same build gives the same digest.",
        "datePublished": provenance["end"],
        "license": {"@id": license_url},
        "author": {"@id": "#author"},
        "conformsTo": {"@id": _PROFILE},
        "mentions": {"@id": "#run"},
        "hasPart": _references(files),
        "variableMeasured": _references([digest, *columns]),
    }
    software = {
        "@id": "#copepod",
        "@type": "SoftwareApplication",
        "name": "Copepod",
        "softwareVersion": provenance["version"],
        "identifier": provenance["git_revision"],
        "description": f"built by {provenance['compiler']}, build {provenance['build']}; components: "
        + ", ".join(provenance["components"].values()),
    }
    run = {
        "@id": "#run",
        "@type": "CreateAction",
        "name": f"the run of {summary['case']} on {provenance['fluid_ranks']} rank(s)",
        "startTime": provenance["start"],
        "endTime": provenance["end"],
        "actionStatus": {"@id": "http://schema.org/CompletedActionStatus"},
        "agent": {"@id": "#author"},
        "instrument": {"@id": "#copepod"},
        "object": {"@id": "case.yaml"},
        "result": _references([file for file in files if file["@id"] != "case.yaml"]),
    }
    about = {"@id": METADATA, "@type": "CreativeWork", "conformsTo": {"@id": _CONTEXT}, "about": {"@id": "./"}}
    terms = {"@id": license_url, "@type": "CreativeWork", "name": license_of_data}
    profile = {"@id": _PROFILE, "@type": "CreativeWork", "name": "Process Run Crate", "version": "0.5"}
    return [about, crate, *files, run, software, writer, terms, profile, digest, *columns]


def _file(folder: Path, name: str, sums: dict[str, str]) -> dict[str, Any]:
    description, kind = _CONTENT[name]
    if (folder / name).is_dir():
        return {"@id": f"{name}/", "@type": "Dataset", "name": name, "description": description}
    size = str((folder / name).stat().st_size)
    entity = {"@id": name, "@type": "File", "name": name, "description": description, "encodingFormat": kind}
    return {**entity, "contentSize": size, "sha256": sums[name]}


def _columns(table: Path) -> Iterator[dict[str, Any]]:
    """Quantities of a table, each with the unit in its name."""
    names: Iterable[str] = ()
    if table.is_file() and table.suffix == ".npy":
        names = np.load(table, mmap_mode="r").dtype.names or ()
    elif table.is_file():
        names = table.read_text().partition("\n")[0].split(",")
    for column in names:
        name, unit = quantity_of(column)
        entity = {"@id": f"#{table.stem}.{column}", "@type": "PropertyValue", "name": f"{name} ({table.name})"}
        yield {**entity, "propertyID": column, **({"unitText": unit} if unit else {})}


def _references(entities: list[dict[str, Any]]) -> list[dict[str, str]]:
    return [{"@id": entity["@id"]} for entity in entities]


def _sha256(path: Path) -> str:
    with open(path, "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
