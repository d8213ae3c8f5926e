"""Lastridge ropes: bars along the netting that shorten it, without any compression."""

from dataclasses import replace

import numpy as np
import pytest

from codend.bag.build import build_bag
from codend.bag.loads import problem_of
from codend.bag.measures import measure_all
from codend.equilibrium import solve as equilibrium
from codend.equilibrium import standing_in
from codend.equilibrium.accuracy import smeared_errors
from codend.equilibrium.bag_model import model_of
from codend.equilibrium.fidelity import Reason, choose
from codend.equilibrium.stability import stability_of, tangent_of, tangent_of_whole
from codend.equilibrium.start_shapes import set_round
from codend.equilibrium.starts import IN_FOLDS_AT_GEAR, Start
from codend.errors import InputError
from codend.mechanics.piercing import first_pierced, touching_m
from codend.plan.kinds import KINDS
from codend.plan.plan import Plan, plan_from_dict
from codend.report.html import cautions
from codend.solvers import newton
from codend.solvers.outcome import Outcome
from codend.studies.case_result import CaseResult
from codend.studies.study import solve
from validation.reference import nodal_loads, residual
from validation.ropes_judged import found, judged
from validation.ropes_short import measured, plan_with
from validation.smeared_ropes import SEED, compare, random_plan

KNOTTED = {"knot_mm": 6.0}


def roped(rope: dict | None = None, *, model: dict | None = None, meshes_round: int = 24, **netting: object) -> Plan:
    section = {"mesh": "diamond", "meshes_round": meshes_round, "meshes_long": 20, "bar_mm": 50.0, "twine_mm": 3.0}
    shape = {"pressure": "uniform", "filled_meshes": 8.0}
    return plan_from_dict(
        {
            "title": "ropes",
            "tow": {"speed_m_s": 0.8},
            "entry": {"radius_m": 0.16 if meshes_round == 24 else 0.3},
            "netting": [section | {"axial_stiffness_n": 1000.0} | netting],
            "rope": [] if rope is None else [rope],
            "catch": shape,
            "model": {"tolerance": 1e-9, **(model or {})},
        }
    )


def case_of(plan: Plan) -> CaseResult:
    result = solve(plan).cases[0]
    assert result.converged, result.report.attempts
    return result


@pytest.mark.parametrize("fidelity", ["auto", "smeared"])
@pytest.mark.parametrize("number", [2, 3, 8])
@pytest.mark.parametrize("rope", [{"shortening": -0.02}, {"shortening": 0.1, "axial_stiffness_n": 1e-6}])
def test_a_rope_longer_than_the_netting_or_without_stiffness_changes_nothing(number, rope, fidelity):
    tables = (None, {}), ({"number": number, **rope}, {"fidelity": fidelity})
    none, with_rope = (case_of(roped(r, model=model)).measures for r, model in tables)
    for name in ("drag_n", "length_m", "opening_ahead_deg", "max_radius_m"):
        assert getattr(with_rope, name) == pytest.approx(getattr(none, name), rel=1e-6)
    assert with_rope.max_rope_tension_n < 1e-5


@pytest.mark.parametrize("mesh", [{"mesh": "diamond"}, KNOTTED | {"mesh": "t90"}, {"mesh": "square"}])
def test_smeared_ropes_of_every_kind_of_netting_balance_and_leave_straps_their_length(mesh):
    rope = {"number": 4, "shortening": 0.1, "axial_stiffness_n": 5000.0, "diameter_mm": 20.0}
    narrow = {"entry": {"radius_m": 0.1}, "strap": [{"length_m": 0.9, "meshes_from_codline": 6}]}
    plan = plan_from_dict(roped(rope, model={"fidelity": "smeared"}, **mesh).to_dict() | narrow)
    result = case_of(plan)
    net, positions = result.net, result.positions
    length, straps = np.linalg.norm(result_vectors(result), axis=1), result.bag.straps
    assert net.order * length[straps].sum() <= net.order * net.bar_length[straps].sum() + 1e-9
    assert result.bar_tension_n[straps].min() > 1.0
    load, ends = nodal_loads(result.problem, positions, result.solution.share)[:, 0], positions[net.bars, 0]
    along = np.abs(np.diff(ends, axis=1)[:, 0]) / length
    for cut in np.linspace(0.05, 0.9, 7) * result.measures.length_m:
        crossing = (ends.min(axis=1) < cut) & (ends.max(axis=1) > cut)
        pulls = (result.solution.bar_tension * along)[crossing].sum()
        assert pulls == pytest.approx(load[positions[:, 0] > cut].sum(), rel=1e-8)


@pytest.mark.parametrize("mesh", [KNOTTED | {"mesh": "t90"}, {"mesh": "square"}])
@pytest.mark.parametrize("rope", [{"shortening": -0.02}, {"shortening": 0.1, "axial_stiffness_n": 1e-6}])
def test_smeared_ropes_that_do_nothing_leave_t90_and_square_mesh_as_they_are(rope, mesh):
    tables = (None, {}), ({"number": 2, **rope}, {"fidelity": "smeared"})
    none, with_rope = (case_of(roped(r, model=model, **mesh)).measures for r, model in tables)
    for name in ("drag_n", "length_m", "opening_ahead_deg", "max_radius_m"):
        assert getattr(with_rope, name) == pytest.approx(getattr(none, name), rel=1e-8)


@pytest.mark.parametrize(
    ("number", "netting"),
    [(2, {}), (4, {}), (3, KNOTTED | {"mesh": "t90"}), (5, {"meshes_round": 50})],
)
def test_equal_ropes_in_a_sector_are_those_of_the_full_net(number, netting):
    """The sector's equilibrium set all round is the full net's, and its load across any cut the drag behind it."""
    plan = roped({"number": number, "shortening": 0.06, "axial_stiffness_n": 5000.0}, **netting)
    sector = case_of(plan)
    assert sector.net.order == number
    whole = model_of(plan, 1, None)
    problem = problem_of(whole.bag, plan, sector.case)
    start = set_round(sector.bag, whole.bag, sector.solution)
    assert residual(problem, start.positions, start.bar_tension, start.share) < 1e-8
    full = newton.solve(problem, 1e-9, start, newton.DIRECT, None, whole.prepared)
    _, _, measures = measure_all(whole.bag, problem, full)
    for name in ("drag_n", "length_m", "opening_ahead_deg", "max_rope_tension_n", "entry_reaction_n"):
        assert getattr(measures, name) == pytest.approx(getattr(sector.measures, name), rel=1e-8)
    assert measures.sideways_imbalance < 1e-8
    assert measures.entry_reaction_n == pytest.approx(measures.drag_n, rel=1e-7)


@pytest.mark.parametrize("stiff", [0.0, 1e-4])
def test_a_straight_rope_behind_netting_that_bulges_has_passed_through_nothing(stiff):
    """Laced to every second row, it cuts through the corner of a mesh: that was refused, of most nets with ropes."""
    section = {"meshes_long": 19, "bar_mm": 50.0, "knot_mm": 8.0, "bending_stiffness_n_m2": stiff}
    rope = {"number": 3, "shortening": 0.12, "axial_stiffness_n": 1e4}
    results = [
        case_of(roped(rope, meshes_round=24, **section, model={"fidelity": fidelity}))
        for fidelity in ("sector", "full")
    ]
    for result in results:
        s, positions = result.problem.structure, result.positions
        facets = s.facets, s.facet_image, s.facet_weight, s.order
        deep = touching_m(s.length, s.diameter)
        for bars, pierces in ((s.is_rope, True), (~s.is_rope, False)):
            pierced = first_pierced(positions, s.first[bars], s.second[bars], s.image[bars], *facets, deep)[0]
            assert (pierced >= 0) == pierces
    sector, whole = (result.measures for result in results)
    assert whole.drag_n == pytest.approx(sector.drag_n, rel=1e-8)


def test_a_short_bag_with_slack_netting_between_its_ropes_is_known_to_last_and_has_errors():
    """Much of it moves for hardly anything: with few eigenvalues nothing was known, and no error was told."""
    tables = roped({"number": 2, "shortening": 0.13}).to_dict()
    section = {"mesh": "diamond", "meshes_round": 14, "meshes_long": 8, "bar_mm": 32.0, "knot_mm": 6.5, "twine_mm": 3.0}
    tables |= {"entry": {"radius_m": 0.066}, "catch": {"filled_meshes": 2.0}, "netting": [section]}
    result = case_of(plan_from_dict(tables))
    whole = case_of(plan_from_dict(tables | {"model": {"fidelity": "full", "tolerance": 1e-9}}))
    assert (result.net.order, whole.net.order) == (2, 1)
    assert result.stability.stable == whole.stability.stable == "yes"
    assert result.errors.drag_error_n <= 1e-6 * result.measures.drag_n


def test_where_it_is_not_known_what_grows_errors_cover_the_most_that_may():
    """Slack netting far ahead of the catch: no more of it grows than the symmetric part of the tangent lets it."""
    rng = np.random.default_rng(SEED)
    *_, plan = (random_plan(rng, "knotted") for _ in range(6))
    result = case_of(plan)
    assert result.stability.stable == "unknown"
    assert 0.0 < result.stability.at_most < 0.1 * result.stability.scale
    assert 0.03 < result.errors.drag_error_n / result.measures.drag_n < 0.1


def test_the_load_in_ropes_and_netting_across_any_cut_is_the_drag_behind_it():
    result = case_of(roped({"number": 4, "shortening": 0.15, "axial_stiffness_n": 5000.0, "diameter_mm": 20.0}))
    net, solution = result.net, result.solution
    load = nodal_loads(result.problem, solution.positions, solution.share)[:, 0]
    ends = solution.positions[net.bars, 0]
    along = np.abs(np.diff(ends, axis=1)[:, 0]) / np.linalg.norm(result_vectors(result), axis=1)
    for cut in np.linspace(0.05, 0.9, 7) * result.measures.length_m:
        crossing = (ends.min(axis=1) < cut) & (ends.max(axis=1) > cut)
        behind = load[solution.positions[:, 0] > cut].sum()
        assert (solution.bar_tension * along)[crossing].sum() == pytest.approx(behind, rel=1e-5)


def result_vectors(result: CaseResult) -> np.ndarray:
    from codend.net.net import bar_vectors

    return bar_vectors(result.net, result.positions)


def test_ropes_carry_no_compression_and_are_as_long_as_their_tension_makes_them():
    result = case_of(roped({"number": 4, "shortening": 0.1, "axial_stiffness_n": 5000.0}))
    ropes = result.bag.ropes
    length = np.linalg.norm(result_vectors(result), axis=1)[ropes]
    tension = result.bar_tension_n[ropes]
    assert (tension >= 0.0).all()
    taut = tension > 0.0
    rest = result.net.bar_length[ropes]
    assert length[taut] == pytest.approx(rest[taut] * (1.0 + tension[taut] / 5000.0), rel=1e-7)
    assert (length[~taut] <= rest[~taut] * (1.0 + 1e-9)).all()
    # a stretched mesh less the shortening
    assert rest == pytest.approx(0.9 * 0.1)


@pytest.mark.parametrize(("number", "shortening", "more"), [(2, 0.1, (4, 8)), (4, 0.1, (4, 9)), (4, 0.2, (12, 18))])
def test_short_ropes_open_the_meshes_ahead_and_raise_the_drag(number, shortening, more):
    """Published: 10 % by 4 to 8 degrees, 20 % by 15 to 18; here at one catch and entry."""
    rope = {"number": number, "shortening": shortening, "axial_stiffness_n": 5000.0}
    keys = {"meshes_round": 50, "meshes_long": 50}
    plans = [
        roped(r, **keys).model_copy(update={"catch": roped().catch.model_copy(update={"filled_meshes": (15.0,)})})
        for r in (None, rope)
    ]
    plain, shorter = (case_of(plan).measures for plan in plans)
    assert more[0] < shorter.opening_ahead_deg - plain.opening_ahead_deg < more[1]
    assert shorter.drag_n > plain.drag_n


def test_the_error_of_smeared_ropes_covers_the_difference_on_random_plans():
    rng = np.random.default_rng(15)
    found = [compare(random_plan(rng)) for _ in range(3)]
    assert all(one is not None and one["worst"] <= 1.0 for one in found)


def test_the_error_of_smeared_ropes_is_wider_where_netting_hangs_in_folds_between_them():
    one = {"number": 4, "shortening": 0.1}
    errors = [smeared_errors(roped(one, mesh=mesh)) for mesh in ("diamond", "t90", "square")]
    assert errors[1:] == [pytest.approx(KINDS[mesh].smeared_errors * errors[0]) for mesh in ("t90", "square")]
    assert all((wider >= errors[0]).all() and wider[3] > errors[0][3] for wider in errors[1:])


def test_ropes_are_real_unless_the_accuracy_in_opening_lets_them_be_smeared():
    rope = {"number": 4, "shortening": 0.1}
    real, quick = choose(roped(rope)), choose(roped(rope, model={"opening_accuracy_deg": 5.0}))
    assert (real.reason, real.fidelity, real.order) == (Reason.ROPES, "sector", 4)
    assert (quick.reason, quick.fidelity) == (Reason.SMEARED, "smeared")


def test_ropes_half_a_mesh_apart_start_at_the_hoop_and_the_table_names_each():
    """50 meshes and 4 ropes: every other one runs half a mesh beside the knots of the entry."""
    study = solve(roped({"number": 4, "shortening": 0.1}, meshes_round=50))
    bag = study.cases[0].bag
    assert (bag.net.order, bag.anchors) == (2, 1)
    assert study.ropes["place_deg"].to_numpy() == pytest.approx([0.0, 90.0])
    assert study.ropes["length_m"].to_numpy() == pytest.approx(0.9 * 2.0)
    assert study.table["max_rope_tension_n"][0] == study.ropes["max_tension_n"].max()


def test_the_weight_of_ropes_is_in_the_full_net():
    rope = {"number": 4, "shortening": 0.1, "diameter_mm": 20.0, "density_kg_m3": 1500.0}
    net = build_bag(roped(rope)).net
    mass = (np.pi / 4 * net.bar_solid_diameter**2 * net.bar_length * net.bar_density)[net.bar_is_rope]
    assert mass.sum() == pytest.approx(4 * 0.9 * 2.0 * np.pi / 4 * 0.02**2 * 1500.0)


BAD = {
    "rope behind the codline": ({"meshes_from_codline": [-5, 10]}, "rope.0.meshes_from_codline.0"),
    "rope ahead of the entry": ({"meshes_from_codline": [0, 21]}, "rope.0.meshes_from_codline.1"),
    "rope from front to back": ({"meshes_from_codline": [10, 5]}, "rope.0.meshes_from_codline"),
    "rope between rows": ({"meshes_from_codline": [0, 10.3]}, "rope.0.meshes_from_codline.1"),
    "more ropes than meshes": ({"number": 25}, "rope.0.number"),
    "no rope": ({"number": 0}, "rope.0.number"),
    "shortening in per cent": ({"shortening": 15}, "rope.0.shortening"),
    "unknown kind": ({"kind": "belly"}, "rope.0.kind"),
    "weight without thickness": ({"density_kg_m3": 900.0}, "rope.0.density_kg_m3"),
    "no shortening": ({"shortening": None}, "rope.0.shortening"),
}


@pytest.mark.parametrize("name", BAD)
def test_ropes_that_cannot_be_are_one_line(name):
    change, key = BAD[name]
    rope = {"number": 2, "shortening": 0.1} | change
    with pytest.raises(InputError) as caught:
        roped({k: v for k, v in rope.items() if v is not None})
    assert caught.value.key == key
    assert len(str(caught.value).splitlines()) == 1


@pytest.mark.parametrize(("number", "shortening", "least", "most"), [(2, 0.1, 4.0, 8.0), (4, 0.2, 15.0, 18.0)])
def test_ropes_of_a_codend_of_fifty_meshes_open_it_ahead_and_raise_its_drag(number, shortening, least, most):
    tube, short = (measured(plan_with(ropes, shortening, 12.0)) for ropes in (0, number))
    assert tube is not None
    assert short is not None
    assert least < short.opening_ahead_deg - tube.opening_ahead_deg < most
    assert short.drag_n > 1.1 * tube.drag_n
    assert short.entry_reaction_n == pytest.approx(short.drag_n, rel=1e-6)


def _fails(situation):
    found = situation.sector_all_round
    return replace(found, report=replace(found.report, outcome=Outcome.NOT_IMPROVING))


def test_smeared_ropes_stand_in_where_none_are_found_as_they_are(monkeypatch):
    monkeypatch.setattr(standing_in, "BETWEEN_ROPES", (Start("nowhere", lambda s: True, _fails),))
    monkeypatch.setattr(standing_in, "MOST_RELAXED", 0)
    plan = random_plan(np.random.default_rng(3))
    study = solve(plan)
    smeared = solve(plan.model_copy(update={"model": plan.model.model_copy(update={"fidelity": "smeared"})}))
    assert study.choice.fidelity == "sector"
    assert study.table["fidelity"].tolist() == ["smeared"]
    columns = ["drag_n", "drag_error_n", "opening_ahead_deg", "opening_ahead_error_deg"]
    assert study.table[columns].iloc[0].tolist() == pytest.approx(smeared.table[columns].iloc[0].tolist(), rel=1e-6)
    assert any("smeared over all meshes" in sentence for sentence in cautions(study))


def test_smeared_ropes_stand_in_for_a_whole_net_under_weight_with_what_that_changes_in_their_errors(monkeypatch):
    """A T0 codend of 40 x 25 meshes with two ropes and 1.3 % of weight ended without an answer after 20 s."""
    nowhere = Start("nowhere", lambda s: True, _fails)
    monkeypatch.setattr(standing_in, "BETWEEN_ROPES", (nowhere,))
    monkeypatch.setattr(standing_in, "MOST_RELAXED", 0)
    plan = random_plan(np.random.default_rng(3))
    heavy = plan.model_copy(
        update={"netting": tuple(part.model_copy(update={"twine_density_kg_m3": 3000.0}) for part in plan.netting)}
    )
    study = solve(heavy)
    assert study.choice.sees_weight
    assert study.table["fidelity"].tolist() == ["smeared"]
    light = solve(plan).cases[0].errors
    assert study.cases[0].errors.opening_ahead_error_deg > light.opening_ahead_error_deg
    assert any("the wet weight is left out" in sentence for sentence in cautions(study))


def test_a_plain_model_written_apart_is_in_balance_where_the_net_between_ropes_is():
    measures, places = found(4, 0.2, 16.0, True)
    plain = judged(4, 0.2, 16.0, True, places)
    assert plain.off_balance < 1e-8
    assert plain.drag_n == pytest.approx(measures.drag_n, rel=1e-8)
    assert plain.opening_ahead_deg[0] == pytest.approx(measures.opening_ahead_deg, abs=1e-6)


def test_netting_in_folds_between_ropes_is_asked_for_its_stability_with_what_presses_on_it():
    """Of the whole net as many parts press on each other as of all its sectors; without them it was told to grow."""
    plan = random_plan(np.random.default_rng(SEED), "t90")
    model, (case,) = model_of(plan, 1, 1), plan.cases()
    problem, solution = equilibrium.solve(model, case, (), None, (IN_FOLDS_AT_GEAR,))
    tangent = tangent_of(model, problem, solution)
    whole = tangent_of_whole(model, tangent)
    pressed = len(problem.loading.contact.kind)
    assert pressed > 0
    assert len(whole.problem.loading.contact.kind) == pressed * model.bag.net.order
    assert stability_of(model, tangent).stable == "yes"
