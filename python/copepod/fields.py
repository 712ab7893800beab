"""fields.h5 as xarray Datasets that read their values when these are used."""

from contextlib import suppress
from pathlib import Path
from typing import Any

import h5py
import numpy
import xarray
from xarray.backends import BackendArray
from xarray.core import indexing

from copepod.errors import Error

_BODY = {"long_name": "0: fluid; else the body that covers the cell, counted from 1"}
_UNITS = {"kg_per_m3": "kg/m3", "m_per_s": "m/s", "per_s": "1/s", "Pa": "Pa"}


def snapshots(directory: Path) -> xarray.Dataset:
    """All snapshots so far, with the coordinates time [s] and step."""
    path = directory / "fields.h5"
    with _opened(path) as file:
        steps = {group.attrs["step"]: name for name, group in file.items() if name.startswith("step_")}
        if not steps:
            raise Error(
                f"{path} has no snapshots (there is only a mean: mean_fields). Set output.fields.every_steps.", 2
            )
        groups = [steps[step] for step in sorted(steps)]
        times = [float(file[name].attrs["time_s"]) for name in groups]
        data, coordinates = _variables(file, path, groups)
    coordinates["time"] = ("time", times, {"units": "s"})
    coordinates["step"] = ("time", sorted(steps))
    return xarray.Dataset(data, coordinates)


def mean(directory: Path) -> xarray.Dataset:
    """The mean over a window of steps; `attrs` has mean_start, mean_stop and the number of samples."""
    path = directory / "fields.h5"
    with _opened(path) as file:
        if "mean" not in file:
            raise Error(f"{path} has no mean (snapshots only: fields). Set output.fields.mean_over_steps.", 2)
        data, coordinates = _variables(file, path, ["mean"])
        attributes = {name: int(file["mean"].attrs[name]) for name in ("mean_start", "mean_stop", "samples")}
    return xarray.Dataset(data, coordinates, attributes).isel(time=0)


def _opened(path: Path) -> Any:
    """The file, open for a moment; the run that writes it must not fail because of a reader."""
    if not path.exists():
        raise Error(f"{path} does not exist (the run has written no fields so far). Set output.fields.", 2)
    try:
        with suppress(OSError):  # this process may have it open with locks
            return h5py.File(path, "r", locking=False)
        return h5py.File(path, "r")
    except OSError as problem:
        raise Error(f"{path} cannot be read ({problem}). While a run writes it, try again.", 73) from None


def _variables(file: Any, path: Path, groups: list[str]) -> tuple[dict[str, Any], dict[str, Any]]:
    """The quantities of some groups, all of one shape, and the coordinates of the cells' centres."""
    first = file[groups[-1]]
    cell_m = float(first.attrs["cell_size_m"])
    shape = first["body"].shape
    coordinates: dict[str, Any] = {"component": list("xyz")}
    for axis, count in zip("zyx", shape):
        start = int(first.attrs.get(f"first_cell_{axis}", 0))
        coordinates[axis] = (axis, (start + numpy.arange(count) + 0.5) * cell_m, {"units": "m"})
    data = {}
    for name, dataset in first.items():
        array = _LazyGroups(path, [f"{group}/{name}" for group in groups if name in file[group]], dataset)
        axes = ("time", *"zyx", "component")[: len(array.shape)]
        quantity, _, unit = name.partition("_")
        attributes = {"long_name": quantity, "units": _UNITS.get(unit, unit)}
        data[name] = xarray.Variable(axes, indexing.LazilyIndexedArray(array), _BODY if name == "body" else attributes)
    if not any("component" in variable.dims for variable in data.values()):
        del coordinates["component"]
    return data, coordinates


class _LazyGroups(BackendArray):
    """One quantity of several groups as an array (group, z, y, x[, component])."""

    def __init__(self, path: Path, names: list[str], like: Any) -> None:
        self._path = path
        self._names = names
        self.dtype = like.dtype
        self.shape = (len(names), *like.shape)

    def __getitem__(self, key: indexing.ExplicitIndexer) -> Any:
        return indexing.explicit_indexing_adapter(key, self.shape, indexing.IndexingSupport.BASIC, self._read)

    def _read(self, key: tuple[Any, ...]) -> Any:
        with _opened(self._path) as file:
            if not isinstance(key[0], slice):
                return file[self._names[key[0]]][key[1:]]
            return numpy.stack([file[name][key[1:]] for name in self._names[key[0]]])
