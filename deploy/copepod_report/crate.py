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
_ARRAY = ("the same as an array of NumPy, a field of shape (bodies, components) each", "application/x-npy")
# What an export holds of a run directory, and what it is. The rest is for resuming, or about the machine.
_CONTENT = {
    "case.yaml": (
        "the case with every default spelled out: `copepod run case.yaml` repeats the run",
        "application/yaml",
    ),
    "provenance.json": ("programs, versions, host, times and command line", "application/json"),
    "summary.json": ("figures and the digest of the final state", "application/json"),
    "trajectory.csv": ("position, orientation, velocities, loads and drive of every body over time", "text/csv"),
    "trajectory.npy": _ARRAY,
    "trajectory_names.txt": ("names of its bodies", "text/plain"),
    "obstacles.csv": ("loads on obstacles over time", "text/csv"),
    "obstacles.npy": _ARRAY,
    "obstacles_names.txt": ("names of the obstacles", "text/plain"),
    "coefficients.csv": ("drag and lift coefficients over time", "text/csv"),
    "flow.csv": ("totals of the flow, probes in it and faces of its domain over time", "text/csv"),
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
        sums = {}
        for path in sorted(path for path in begun.rglob("*") if path.is_file()):
            with open(path, "rb") as file:
                sums[path.relative_to(begun).as_posix()] = hashlib.file_digest(file, "sha256").hexdigest()
        (begun / _SUMS).write_text("".join(f"{digest}  {name}\n" for name, digest in sums.items()))
        graph = _graph(begun, sums, author, license_of_data)
        description = {"@context": [f"{_CONTEXT}/context", _TERMS], "@graph": graph}
        (begun / METADATA).write_text(json.dumps(description, indent=2) + "\n")
        begun.rename(folder)
    return folder / METADATA


def _graph(folder: Path, sums: dict[str, str], author: str, license_of_data: str) -> list[dict[str, Any]]:
    """The entities of the description: crate, files, run, software and measured quantities."""
    provenance, summary = (read_object(folder / f"{name}.json") for name in ("provenance", "summary"))
    files = [_file(folder, name, sums) for name in _CONTENT if (folder / name).exists()]
    tables = ("trajectory.csv", "trajectory.npy", "cycles.csv", "flow.csv", "coefficients.csv")
    columns = [column for name in tables for column in _columns(folder / name)]
    digest = {**_entity("#digest", "PropertyValue", "digest"), "value": summary["digest"]}
    license_url = license_of_data if "://" in license_of_data else f"https://spdx.org/licenses/{license_of_data}"
    crate = {
        **_entity("./", "Dataset", f"Copepod run {summary['case']}"),
        "description": f"A coupled simulation of a fluid and moving bodies, with Copepod {provenance['version']}. To "
        "repeat it: copepod run case.yaml; the same build gives the same digest.",
        "datePublished": provenance["end"],
        **_references(license=license_url, author="#author", conformsTo=_PROFILE, mentions="#run"),
        "hasPart": [_reference(file["@id"]) for file in files],
        "variableMeasured": [_reference(measured["@id"]) for measured in (digest, *columns)],
    }
    software = {
        **_entity("#copepod", "SoftwareApplication", "Copepod"),
        "softwareVersion": provenance["version"],
        "identifier": provenance["git_revision"],
        "description": f"built by {provenance['compiler']}, build {provenance['build']}; components: "
        + ", ".join(provenance["components"].values()),
    }
    completed = "http://schema.org/CompletedActionStatus"
    run = {
        **_entity("#run", "CreateAction", f"the run of {summary['case']} on {provenance['fluid_ranks']} rank(s)"),
        "startTime": provenance["start"],
        "endTime": provenance["end"],
        **_references(actionStatus=completed, agent="#author", instrument="#copepod", object="case.yaml"),
        "result": [_reference(file["@id"]) for file in files if file["@id"] != "case.yaml"],
    }
    about = {"@id": METADATA, "@type": "CreativeWork", **_references(conformsTo=_CONTEXT, about="./")}
    writer = _entity("#author", "Person", author)
    terms = _entity(license_url, "CreativeWork", license_of_data)
    profile = {**_entity(_PROFILE, "CreativeWork", "Process Run Crate"), "version": "0.5"}
    return [about, crate, *files, run, software, writer, terms, profile, digest, *columns]


def _entity(identifier: str, kind: str, name: str) -> dict[str, Any]:
    return {"@id": identifier, "@type": kind, "name": name}


def _file(folder: Path, name: str, sums: dict[str, str]) -> dict[str, Any]:
    description, kind = _CONTENT[name]
    if (folder / name).is_dir():
        return {**_entity(f"{name}/", "Dataset", name), "description": description}
    size = str((folder / name).stat().st_size)
    about = {"description": description, "encodingFormat": kind, "contentSize": size, "sha256": sums[name]}
    return {**_entity(name, "File", name), **about}


def _columns(table: Path) -> Iterator[dict[str, Any]]:
    """Quantities of a table, each with the unit in its name."""
    names: Iterable[str] = ()
    if table.is_file() and table.suffix == ".npy":
        names = np.load(table, mmap_mode="r").dtype.names or ()
    elif table.is_file():
        names = table.read_text().partition("\n")[0].split(",")
    for column in names:
        name, unit = quantity_of(column)
        entity = _entity(f"#{table.stem}.{column}", "PropertyValue", f"{name} ({table.name})")
        yield {**entity, "propertyID": column, **({"unitText": unit} if unit else {})}


def _reference(identifier: str) -> dict[str, str]:
    return {"@id": identifier}


def _references(**identifiers: str) -> dict[str, Any]:
    return {key: _reference(identifier) for key, identifier in identifiers.items()}
