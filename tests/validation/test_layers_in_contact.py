"""Second layers as nets of their own, in contact with the netting below."""

import numpy as np
import pytest

from codend.bag.measures import measure_all
from codend.mechanics.sheet import sheet_of
from codend.net.net import rotate
from codend.solvers.refusal import passage
from codend.studies.study import solve
from validation.layers_in_contact import codend_plan, compare, slid


def test_a_layer_that_does_not_reach_the_netting_below_changes_nothing_in_contact_either():
    found = compare(codend_plan(24, 1.6, 6))
    assert found["residual"] < 1e-6
    assert abs(found["drag_changes"]) < 1e-5
    assert abs(found["opening_changes_deg"]) < 1e-3


def test_a_layer_that_slides_leaves_more_drag_and_pierces_nothing():
    plan = codend_plan(24, 0.95, 6)
    modelled = solve(plan).cases[0]
    found = slid(plan, modelled)
    assert found is not None
    bag, problem, solution = found
    assert solution.report.outcome.converged
    assert passage(problem, solution.positions) is None
    more = measure_all(bag, problem, solution)[2].drag_n / modelled.measures.drag_n - 1.0
    assert 0.0 < more < 0.05
    ipctk = pytest.importorskip("ipctk")
    sheet, order = sheet_of(bag.net), round(bag.net.order)
    turns = np.arange(order)
    nodes = len(solution.positions)
    whole = rotate(np.broadcast_to(solution.positions, (order, nodes, 3)), turns[:, None], bag.net.order).reshape(-1, 3)
    own = np.where(sheet.on_axis, 0, 1)

    def all_round(node, image):
        turned = (turns[:, None, None] + image) % order * own[node]
        return (turned * nodes + node).reshape(-1, node.shape[1])

    faces = all_round(sheet.face, sheet.face_image)
    faces = faces[faces[:, 1] != faces[:, 2]]
    edges = all_round(sheet.edge, sheet.edge_image)
    mesh = ipctk.CollisionMesh(whole, edges.astype(np.int32), faces.astype(np.int32))
    assert not ipctk.has_intersections(mesh, whole)
