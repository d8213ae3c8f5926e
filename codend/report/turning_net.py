"""The net that turns under the mouse: a page of its own that needs nothing from elsewhere, drawn by Plotly."""

from importlib.util import find_spec

import numpy as np

from codend.bag.bag import all_round
from codend.report.polygons import joined_on_axis, mesh_polygons
from codend.studies.case_result import CaseResult

TURNING = "net.html"
"""Name of the page beside ``report.html``."""
CAMERA = {"eye": {"x": -0.6, "y": -2.2, "z": 0.8}}
"""Where one looks from at first: abeam, a little upstream and above."""


def can_turn() -> bool:
    """Whether Plotly is installed: ``pip install 'codend[turn]'``."""
    return find_spec("plotly") is not None


def turning_page(result: CaseResult, title: str) -> str:
    """The whole net of a solved case, every mesh coloured by its opening, as an HTML page.

    Raises:
        ValueError: the case was not solved.
    """
    import plotly.graph_objects as go

    if result.meshes is None:
        raise ValueError(f"case {result.case.number} was not solved: there is no shape to draw")
    whole = joined_on_axis(all_round(result.bag, result.positions))
    opening = np.tile(result.meshes.opening_deg, result.net.sectors)
    triangles, of_mesh = [], []
    for which, corners in mesh_polygons(whole):
        for corner in range(1, corners.shape[1] - 1):
            triangles.append(corners[:, [0, corner, corner + 1]])
            of_mesh.append(which)
    (x, y, z), (i, j, k) = whole.positions.T.astype(np.float32), np.concatenate(triangles).T
    netting = go.Mesh3d(
        x=x,
        y=y,
        z=z,
        i=i,
        j=j,
        k=k,
        intensity=opening[np.concatenate(of_mesh)].astype(np.float32),
        intensitymode="cell",
        colorscale="Viridis",
        colorbar={"title": "opening (degrees)"},
        flatshading=True,
        hoverinfo="skip",
    )
    axes = {name: {"title": words} for name, words in (("xaxis", "aft (m)"), ("yaxis", "m"), ("zaxis", "up (m)"))}
    figure = go.Figure(netting, {"title": title, "scene": {"aspectmode": "data", "camera": CAMERA, **axes}})
    page: str = figure.to_html(include_plotlyjs=True, full_html=True)
    return page
