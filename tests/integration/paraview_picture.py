"""Opens a run in ParaView, prints what is there, and makes the picture of docs/paraview.md.

    pvbatch --force-offscreen-rendering tests/integration/paraview_picture.py RUN_DIR PICTURE.png

On the left the last snapshot with the bodies at its time, on the right the mean; colours of bodies show the force.
"""

import sys
from pathlib import Path

from paraview import simple as pv  # type: ignore[import-not-found]
from paraview import servermanager  # type: ignore[import-not-found]

_BLACK = [0.1, 0.1, 0.1]


def describe(name, source, time):
    source.UpdatePipeline(time)
    data = source.GetDataInformation()
    bounds = " ".join(f"{bound * 1e6:.2f}" for bound in data.GetBounds())
    arrays = [source.CellData.GetArray(i).GetName() for i in range(source.CellData.GetNumberOfArrays())]
    print(f"{name}: {list(source.TimestepValues)} s\n  bounds {bounds} µm\n  of cells: {', '.join(arrays)}")


def middle_slice(source):
    """The plane normal to x through the middle of the domain, where the swimmer is."""
    cut = pv.Slice(Input=source)
    bounds = source.GetDataInformation().GetBounds()
    # Off the faces of cells, so that the plane belongs to one layer of them.
    cut.SliceType.Origin = [0.5 * (bounds[0] + bounds[1]) - 1e-9, 0, 0]
    cut.SliceType.Normal = [1, 0, 0]
    return cut


def show(view, fields, bodies, title, largest):
    shown = pv.Show(middle_slice(fields), view)
    pv.ColorBy(shown, ("CELLS", "velocity_m_per_s", "Magnitude"))
    surfaces = pv.Show(bodies, view)
    pv.ColorBy(surfaces, ("CELLS", "force_N", "Magnitude"))
    for representation, name, preset in ((shown, "velocity_m_per_s", "Inferno"), (surfaces, "force_N", "Viridis")):
        colours = pv.GetColorTransferFunction(name)  # the same for both views
        colours.ApplyPreset(f"{preset} (matplotlib)", True)
        colours.RescaleTransferFunction(0, largest[name])
        representation.SetScalarBarVisibility(view, True)
        bar = pv.GetScalarBar(colours, view)
        bar.Title, bar.ComponentTitle = {"force_N": "force [N]", "velocity_m_per_s": "speed [m/s]"}[name], ""
        bar.TitleColor = bar.LabelColor = _BLACK
        bar.TitleFontSize = bar.LabelFontSize = 13
        bar.LabelFormat = bar.RangeLabelFormat = "%.1e"
        bar.WindowLocation = "Any Location"
        bar.Position = [0.02 if name == "force_N" else 0.83, 0.28]
        bar.ScalarBarLength = 0.45
    text = pv.Show(pv.Text(Text=title), view)
    text.Color, text.FontSize, text.WindowLocation = _BLACK, 15, "Lower Center"


def main():
    run, picture = Path(sys.argv[1]), sys.argv[2]
    pv._DisableFirstRenderCameraReset()
    bodies = pv.OpenDataFile(str(run / "bodies.pvd"))
    snapshots = pv.OpenDataFile(str(run / "fields.xdmf"))
    mean = pv.OpenDataFile(str(run / "fields_mean.xdmf"))
    last = list(snapshots.TimestepValues)[-1]
    for name, source in (("bodies.pvd", bodies), ("fields.xdmf", snapshots), ("fields_mean.xdmf", mean)):
        describe(name, source, last)
    table = servermanager.Fetch(bodies).GetCellData()
    for body in range(table.GetNumberOfTuples()):
        velocity = table.GetArray("velocity_m_per_s").GetTuple3(body)
        print(f"  {table.GetAbstractArray('name').GetValue(body)}: velocity {velocity} m/s")
    largest = {
        name: source.CellData.GetArray(name).GetRange(-1)[1]
        for name, source in (("velocity_m_per_s", snapshots), ("force_N", bodies))
    }
    layout = pv.CreateLayout("run")
    for fields, title in ((snapshots, f"last snapshot, {last * 1e6:.3f} µs"), (mean, "mean")):
        view = pv.CreateRenderView(UseColorPaletteForBackground=0, Background=[1, 1, 1], OrientationAxesVisibility=1)
        view.OrientationAxesLabelColor = _BLACK
        view.ViewTime = last
        pv.AssignViewToLayout(view=view, layout=layout, hint=0)
        show(view, fields, bodies, title, largest)
        view.CameraPosition, view.CameraViewUp = [1, 1.1, 0.35], [0, 0, 1]
        view.CameraFocalPoint = [0, 0, 0]
        pv.ResetCamera(view)
        view.GetActiveCamera().Dolly(0.97)
    layout.SetSize(1100, 640)
    pv.SaveScreenshot(picture, layout, SaveAllViews=1)


main()
