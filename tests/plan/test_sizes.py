"""The trade's sizes: gauge, titre, material and hanging ratio, and what follows from them."""

import math

import pytest

from codend.bag.build import build_bag
from codend.errors import InputError
from codend.plan.amounts import amounts_of
from codend.plan.plan import Plan, plan_from_dict
from codend.plan.tables import Netting
from codend.report.size_words import mass_text, size_sentences
from codend.selectivity.escape.catches import catches_of, run_of
from codend.studies.study import solve

GAUGE = {"inside_mesh_mm": 100.0, "knot_mm": 12.0}
SECTION = {"mesh": "diamond", "meshes_round": 60, "meshes_long": 40, "name": "codend"}


def section(**keys: object) -> Netting:
    keys = {"twine_mm": 4.0, **SECTION, **keys}
    return Netting.model_validate({name: value for name, value in keys.items() if value is not None})


def plan(entry: dict[str, float] | None = None, **keys: object) -> Plan:
    keys = {"twine_mm": 4.0, **SECTION, **GAUGE, **keys}
    return plan_from_dict(
        {
            "title": "sizes",
            "tow": {"speed_m_s": 1.2},
            "entry": entry or {"radius_m": 0.5},
            "netting": [{name: value for name, value in keys.items() if value is not None}],
            "catch": {"filled_meshes": 10},
        }
    )


def test_the_gauge_measures_the_full_mesh_less_one_knot():
    gauged = section(**GAUGE)
    assert gauged.bar_m == pytest.approx(0.044)
    assert gauged.full_mesh_m == pytest.approx(0.112)
    assert section(mesh_mm=112.0, knot_mm=12.0).inside_mesh_m == pytest.approx(0.100)
    assert section(bar_mm=44.0, knot_mm=12.0).inside_mesh_m == pytest.approx(0.100)


def test_a_knot_left_out_is_two_twines_wide_to_the_gauge_and_that_is_said():
    gauged = section(inside_mesh_mm=100.0, twines=2)
    assert gauged.knot_m == 0.0
    assert gauged.full_mesh_m == pytest.approx(0.100 + 2 * 0.008)
    assert gauged.inside_mesh_m == pytest.approx(0.100)
    assert "two twines wide is taken, 16 mm" in size_sentences(plan(knot_mm=None, twines=2))[0]


@pytest.mark.parametrize("mesh", ["diamond", "t90", "square"])
def test_one_inside_mesh_stands_in_every_table_and_is_what_fish_meet(mesh):
    size = {"knot_mm": None} if mesh == "square" else {}
    study = solve(plan(mesh=mesh, meshes_round=100 if mesh == "square" else 60, **size))
    for table in (study.table, study.profile):
        assert table["inside_mesh_mm"].to_numpy() == pytest.approx(100.0)
    holes = catches_of(run_of(study), 5.0)[0].holes
    assert 2.0 * holes.bar_m + holes.knot_m == pytest.approx(0.100)


def test_titre_is_told_in_three_ways_and_gives_thickness_and_solid_diameter():
    ways = ({"rtex": 720.0}, {"runnage_m_kg": 1e6 / 720.0}, {"twine_number": "210/24"})
    found = [section(**GAUGE, twine_mm=None, material="PE", **way) for way in ways]
    assert found[0].mass_kg_m == pytest.approx(7.2e-4)
    assert found[1].mass_kg_m == pytest.approx(7.2e-4)
    assert found[2].mass_kg_m == pytest.approx(210.0 / 9.0 * 24 * 1.1 * 1e-6)
    assert found[0].twine_mm is None
    assert found[0].twine_m == pytest.approx(0.0432e-3 * 720.0**0.499)
    assert found[0].solid_diameter_m == pytest.approx(math.sqrt(4 * 7.2e-4 / (math.pi * 950.0)))
    # a thickness of its own leaves the mass alone
    assert section(**GAUGE, twine_mm=1.5, rtex=720.0, material="PE").mass_kg_m == pytest.approx(7.2e-4)


@pytest.mark.parametrize("mesh", ["diamond", "t90", "square"])
@pytest.mark.parametrize("twines", [1, 2])
def test_the_mass_of_the_netting_is_its_twine_times_the_runnage_and_that_of_the_nets_bars(mesh, twines):
    keys = {"mesh": mesh, "rtex": 2000.0, "material": "PA", "twines": twines}
    of_plan = plan(**keys, **({"knot_mm": None} if mesh == "square" else {}))
    amounts = amounts_of(of_plan.netting[0])
    assert amounts.mass_kg == pytest.approx(amounts.twine_m / (1e6 / 2000.0), rel=1e-12)
    net = build_bag(of_plan).net
    bars = net.bar_length * net.bar_solid_diameter**2 * math.pi / 4 * 1140.0
    # a row of knots of T90 and a ring of square bars are the hoop's, which are no bars
    error = {"diamond": 1e-12, "t90": 2e-3, "square": 0.02}[mesh]
    assert bars.sum() == pytest.approx(amounts.mass_kg, rel=error)
    assert (net.bar_density == 1140.0).all()


def test_the_hanging_ratio_sets_the_way_round_the_entry():
    hung = plan({"hanging_ratio": 0.3})
    assert 2 * math.pi * hung.entry_radius_m == pytest.approx(0.3 * 60 * 0.112)
    assert any("hanging ratio" in sentence for sentence in size_sentences(hung))


def test_masses_are_told_in_tonnes_from_a_tonne_on():
    assert mass_text(950.0) == "950 kg"
    assert mass_text(2345.0) == "2.35 t"  # 3 digits


BAD = {
    "two titres": ({"rtex": 700.0, "runnage_m_kg": 1400.0, "material": "PE"}, "netting.0.runnage_m_kg"),
    "titre without material": ({"rtex": 700.0}, "netting.0.material"),
    "unknown material": ({"rtex": 700.0, "material": "nylon"}, "netting.0.material"),
    "no such twine number": ({"twine_number": "210-24", "material": "PA"}, "netting.0.twine_number"),
    "no thickness follows": ({"twine_mm": None, "rtex": 700.0, "material": "PVA"}, "netting.0.twine_mm"),
    "two sizes of mesh": ({"mesh_mm": 120.0}, "netting.0.inside_mesh_mm"),
    "no inside left": ({"inside_mesh_mm": 10.0}, "netting.0.inside_mesh_mm"),
    "two entries": ({"entry": {"radius_m": 0.5, "hanging_ratio": 0.3}}, "entry.hanging_ratio"),
    "square mesh hung": ({"entry": {"hanging_ratio": 0.3}, "mesh": "square", "knot_mm": None}, "entry.hanging_ratio"),
    "hung flat": ({"entry": {"hanging_ratio": 0.99}, "knot_mm": 20.0}, "entry.hanging_ratio"),
}


@pytest.mark.parametrize("name", BAD)
def test_contradictions_of_sizes_are_one_line_that_names_the_key(name):
    keys, key = BAD[name]
    with pytest.raises(InputError) as caught:
        plan(**keys)
    assert caught.value.key == key
    assert len(str(caught.value).splitlines()) == 1


def test_windows_are_sized_and_solid_twine_is_said_to_be_heavier_than_real():
    window = {"netting": "codend", "mesh": "square", "meshes_round": 4, "meshes_long": 8, "bar_mm": 50.0}
    window |= {"meshes_across": 4, "meshes_from_codline": [4, 8], "material": "PA", "twine_mm": 4.0}
    sizes = {
        "title": "sizes",
        "tow": {"speed_m_s": 1.2},
        "entry": {"radius_m": 0.5},
        "netting": [SECTION | GAUGE | {"twine_mm": 4.0}],
        "catch": {"filled_meshes": 10},
    }
    said = size_sentences(plan_from_dict(sizes | {"window": [window]}))
    assert any(sentence.startswith("Window 1: bar 50 mm") for sentence in said)
    solid = 1140.0 * math.pi / 4 * 0.004**2 * 1e6
    assert any(
        f"Window 1: twine density 1140 kg/m3, that of PA; as a solid rod it is R{solid:.0f} tex" in s for s in said
    )
    # 8 bars of 50 mm in the place of 4 meshes of 112 mm
    assert not any("too long" in sentence for sentence in said)
    longer = size_sentences(plan_from_dict(sizes | {"window": [window | {"meshes_long": 10}]}))
    assert any("Window 1: stretched 0.5 m long in a place that is 0.448 m stretched" in sentence for sentence in longer)
    # 4 and 10 bars of 50 mm in the place of 8 of 44 mm
    assert not any("too wide" in sentence for sentence in [*said, *longer])
    wider = size_sentences(plan_from_dict(sizes | {"window": [window | {"meshes_round": 10}]}))
    assert any(
        "Window 1: 0.5 m wide pulled fully open, in a place that is 0.352 m so" in sentence for sentence in wider
    )
