"""Nets that differ in their sizes only share what counts decide, and no net ever gets another's."""

import random
from dataclasses import fields

import numpy as np
import pytest

from codend.bag.bag import Bag
from codend.bag.build import build_bag
from codend.bag.loads import problem_of
from codend.bag.near_ratio import NearRatio, near_ratios
from codend.net.last_made import LastMade
from codend.net.net import Net
from codend.netting import frame
from codend.plan.plan import plan_from_dict

BASE = {"mesh": "diamond", "meshes_round": 48, "meshes_long": 12, "bar_mm": 50.0, "twine_mm": 4.0}
SIZES = [{"bar_mm": 41.0}, {"twine_mm": 3.0, "twines": 2}, {"twine_density_kg_m3": 950.0, "axial_stiffness_n": 3e3}]
COUNTS = [{"meshes_round": 50}, {"meshes_round": 47}, {"meshes_long": 11}, {"meshes_round_aft": 44}]
COUNTS += [{"panels": 2, "meshes_round_aft": 40}, {"panels": 2, "selvedge_meshes": 2}, {"selvedge_meshes": 1}]
KINDS = [{"mesh": "t90"}, {"mesh": "square"}, {"knot_mm": 9.0}, {"mesh": "t90", "knot_mm": 9.0}]
STIFF = [{"bending_stiffness_n_m2": 1e-4}, {"bending_stiffness_n_m2": 1e-4, "rest_opening_deg": 40.0}]
BEHIND = [{}, {"meshes_round": 36}, {"mesh": "t90", "knot_mm": 9.0}, {"meshes_round": 32, "meshes_long": 5}]


def plan(*sections, **tables):
    tow, catch = {"speed_m_s": 1.5}, {"filled_meshes": 3.0}
    return plan_from_dict(
        {"title": "net", "tow": tow, "entry": {"radius_m": 0.3}, "catch": catch, "netting": list(sections)} | tables
    )


def nets():
    """Plans that are all but the same, and how their nets are built."""
    plans = [plan(BASE | more) for more in [{}, *SIZES, *COUNTS, *KINDS, *STIFF]]
    plans += [plan(BASE | more, BASE | behind) for more in ({}, SIZES[0], KINDS[2]) for behind in BEHIND]
    knotted = BASE | {"knot_mm": 9.0}
    plans += [plan(BASE | ahead, knotted | aft) for ahead, aft in (({}, COUNTS[2]), (COUNTS[2], {}))]
    rope = {"number": 4, "shortening": 0.1, "diameter_mm": 20.0}
    plans += [plan(BASE | more, rope=[rope | ends]) for more in ({}, KINDS[2]) for ends in ({}, {"number": 6})]
    plans += [plan(BASE, strap=[{"meshes_from_codline": 4.0, "length_m": around}]) for around in (1.6, 1.7)]
    plans += [plan(BASE, model={"bars_per_side": 2}), plan(BASE | {"bar_mm": 41.0}, model={"bars_per_side": 2})]
    window = {"netting": "1", "mesh": "square", "meshes_round": 6, "meshes_long": 4, "bar_mm": 45.0, "twine_mm": 4.0}
    plans += [plan(BASE, window=[window | {"meshes_from_codline": [2, 6], "meshes_across": n}]) for n in (6, 8)]
    # as wide a sector: of half the net, of three narrower ones side by side, and all the net
    yield plan(BASE | {"meshes_round": 96}), {"sectors": 48}
    joined = plan(BASE, BASE | {"meshes_round": 36})
    yield joined, {"sectors": 3}
    yield joined, {"near": NearRatio((12, 9), 4.0, (0.0, 0.0))}
    for one in plans:
        yield one, {}
        yield one, {"sectors": 1}
        if one.rope:
            yield one, {"sectors": 1, "smeared": True}
        if 2 in one.globalisations:
            yield one, {"globalisation": 2, "sectors": 1}
        if not one.window:
            for near in list(near_ratios(one))[:2]:
                yield one, {"near": near, "smeared": bool(one.rope)}


NETS = list(nets())


def built(one, options):
    """All arrays of a net and its problem, by name, as bytes, and all else as it reads."""
    bag = build_bag(one, **options)
    found = {}

    def add(name, value):
        if isinstance(value, Bag | Net):
            for field in fields(value):
                add(f"{name}.{field.name}", getattr(value, field.name))
        elif isinstance(value, np.ndarray):
            found[name] = value.dtype, value.shape, value.tobytes()
        elif isinstance(value, tuple) and hasattr(value, "_fields"):
            for part in value._fields:
                add(f"{name}.{part}", getattr(value, part))
        else:
            found[name] = repr(value)

    problem = problem_of(bag, one, one.cases()[0])
    for name, value in (("bag", bag), ("kernel", bag.structure), ("net", problem.structure), ("rings", problem.rings)):
        add(name, value)
    return found


def forget(monkeypatch, most=frame.MOST_KNOTS):
    monkeypatch.setattr(frame, "_frames", LastMade(most))


def test_a_net_is_the_same_after_any_other(monkeypatch):
    alone = []
    for net in NETS:
        forget(monkeypatch)
        alone.append(built(*net))
    forget(monkeypatch, most=10**9)
    order = list(range(len(NETS))) * 2
    random.Random(1).shuffle(order)
    for number in order:
        assert built(*NETS[number]) == alone[number], NETS[number]


@pytest.mark.parametrize("more", SIZES)
@pytest.mark.parametrize("options", [{}, {"sectors": 1}])
def test_nets_that_differ_in_sizes_share_their_frame(more, options, monkeypatch):
    forget(monkeypatch)
    one, other = (build_bag(plan(BASE | sizes), **options) for sizes in ({}, more))
    assert other.net.bars is one.net.bars
    assert other.mesh_sides is one.mesh_sides
    assert other.node_row is one.node_row
    assert build_bag(plan(BASE | {"meshes_long": 11}), **options).net.bars is not one.net.bars


def test_sectors_of_counts_in_one_ratio_share_their_frame(monkeypatch):
    forget(monkeypatch)
    one, other = (build_bag(plan(BASE | {"meshes_round": count}), sectors=1) for count in (48, 60))
    assert other.net.bars is one.net.bars
    assert (one.net.order, other.net.order) == (48, 60)


def test_what_is_kept_stays_as_large_as_it_may_be():
    made = LastMade(10)
    asked = []

    def of(key, size):
        return made.of(key, size, lambda: asked.append(key) or key)

    for key, size in (("a", 4), ("b", 5), ("a", 4), ("c", 4), ("a", 4), ("too large", 11), ("c", 4), ("b", 5)):
        assert of(key, size) == key
    # b gave way to c, for a was asked for in between
    assert asked == ["a", "b", "c", "too large", "b"]
