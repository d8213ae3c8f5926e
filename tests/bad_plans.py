"""Broken plans, as data: each must end in a single line that names the file and the key, whoever reads the plan."""

from typing import NamedTuple

from codend.errors import InputError

VALID_PLAN = """\
title = "Two sections"

[tow]
speed_m_s = [1.0, 1.5]
water_density_kg_m3 = 1026.0

[entry]
radius_m = 0.30

[[netting]]
mesh = "diamond"
meshes_round = 100
meshes_long = 40
bar_mm = 40.0
knot_mm = 5.0
twine_mm = 3.0
twines = 1
twine_density_kg_m3 = 1140.0
axial_stiffness_n = 1000.0
bending_stiffness_n_m2 = 1e-4
rest_opening_deg = 20.0

[[netting]]
mesh = "t90"
meshes_round = 50
meshes_long = 60
mesh_mm = 100.0
knot_mm = 10.0
twine_mm = 4.0
twines = 2

[[strap]]
meshes_from_codline = 30
length_m = 3.5
axial_stiffness_n = 5e5
diameter_mm = 24.0

[catch]
filled_meshes = [20, 40.5, 60]
density_kg_m3 = 1000.0
pressure = "uniform"
coefficient = 1.3

[drag]
law = "le-bris-1999"
normal = 1.36
tangential = 0.07

[model]
fidelity = "globalised"
globalisation = 10
bars_per_side = 1
method = "auto"
damping = "kinetic"
tolerance = 1e-6
"""


class BadPlan(NamedTuple):
    """A change to the text of VALID_PLAN that breaks it, and the key the message must name ("" for the whole file)."""

    id: str
    old: str
    new: str
    key: str

    @property
    def text(self) -> str:
        assert VALID_PLAN.count(self.old) >= 1
        return VALID_PLAN.replace(self.old, self.new, 1)


CATCH = "filled_meshes = [20, 40.5, 60]"
TOW = "[tow]\nspeed_m_s = [1.0, 1.5]\nwater_density_kg_m3 = 1026.0\n"
GLOBALISED = 'fidelity = "globalised"\nglobalisation = 10'

STRAP = "strap.0.meshes_from_codline"
SECOND_STRAP = "[[strap]]\nmeshes_from_codline = 30\nlength_m = 3.0\n"


def roped(id: str, keys: str, key: str) -> BadPlan:
    """A plan with ropes, some of whose keys are others."""
    given = "".join(f"{line}\n" for line in ROPE if line.split()[0] != keys.split(maxsplit=1)[0])
    return BadPlan(id, "[catch]", f"[[rope]]\n{given}{keys}\n\n[catch]", f"rope.0.{key}")


def windowed(id: str, keys: str, key: str) -> BadPlan:
    """A plan with a window, some of whose keys are others."""
    given = "".join(f"{line}\n" for line in WINDOW if line.split()[0] != keys.split(maxsplit=1)[0])
    return BadPlan(id, "[catch]", f"[[window]]\n{given}{keys}\n\n[catch]", f"window.0.{key}")


def sewn(id: str, keys: str, key: str) -> BadPlan:
    """A plan whose first section has more keys."""
    return BadPlan(id, "meshes_long = 40\n", f"meshes_long = 40\n{keys}\n", f"netting.0.{key}")


ROPE = ("number = 2", "shortening = 0.1")
WINDOW = (
    'mesh = "square"',
    "meshes_round = 10",
    "meshes_long = 20",
    "bar_mm = 45.0",
    "twine_mm = 4.0",
    'netting = "2"',
    "meshes_from_codline = [40, 50]",
    "meshes_across = 10",
)
ONE_WINDOW = "[[window]]\n" + "".join(f"{line}\n" for line in WINDOW)
ONE_LOWER = ONE_WINDOW.replace("[40, 50]", "[20, 40]")
FOUR_ROPES = "[[rope]]\nnumber = 4\nshortening = 0.1\n"

BAD_PLANS = [
    # not TOML
    BadPlan("no-closing-bracket", "[entry]", "[entry", ""),
    BadPlan("key-twice", 'mesh = "t90"', 'mesh = "t90"\nmesh = "t90"', ""),
    BadPlan("no-closing-list", CATCH, "filled_meshes = [20,", ""),
    BadPlan("nested-too-deep", CATCH, f"filled_meshes = {'[' * 5000}", ""),
    BadPlan("whole-number-too-long", "meshes_round = 100", f"meshes_round = {'9' * 5000}", ""),
    # unknown keys
    BadPlan("unknown-table", "[model]", "[modle]", "modle"),
    BadPlan("unknown-key", "knot_mm = 5.0", "knots_mm = 5.0", "netting.0.knots_mm"),
    BadPlan("unknown-strap-key", "length_m = 3.5", "length_mm = 3500", "strap.0.length_mm"),
    BadPlan("misspelt-required-key", "meshes_round = 50", "meshes_rond = 50", "netting.1.meshes_rond"),
    BadPlan("key-in-the-wrong-table", "radius_m = 0.30", "radius_m = 0.30\ntwine_mm = 3.0", "entry.twine_mm"),
    BadPlan("key-with-line-break", "radius_m = 0.30", '"radius\\nm" = 0.30', "entry.radius m"),
    BadPlan("private-name", "title", "_source = 'x'\ntitle", "_source"),
    # missing keys
    BadPlan("no-title", 'title = "Two sections"', "", "title"),
    BadPlan("no-tow", TOW, "", "tow"),
    BadPlan("no-speed", "speed_m_s = [1.0, 1.5]", "", "tow.speed_m_s"),
    BadPlan("no-entry-radius", "radius_m = 0.30", "", "entry.radius_m"),
    BadPlan("no-mesh-kind", 'mesh = "t90"\n', "", "netting.1.mesh"),
    BadPlan("no-meshes-long", "meshes_long = 40", "", "netting.0.meshes_long"),
    BadPlan("no-mesh-size", "bar_mm = 40.0", "", "netting.0.bar_mm"),
    BadPlan("no-twine", "twine_mm = 4.0", "", "netting.1.twine_mm"),
    BadPlan("no-strap-length", "length_m = 3.5", "", "strap.0.length_m"),
    BadPlan("no-catch", CATCH, "", "catch.filled_meshes"),
    # wrong types
    BadPlan("number-as-text", "radius_m = 0.30", 'radius_m = "0.30"', "entry.radius_m"),
    BadPlan("number-as-bool", "radius_m = 0.30", "radius_m = true", "entry.radius_m"),
    BadPlan("number-as-date", "radius_m = 0.30", "radius_m = 1999-03-08", "entry.radius_m"),
    BadPlan("number-as-list", "bar_mm = 40.0", "bar_mm = [40.0]", "netting.0.bar_mm"),
    BadPlan("text-as-number", 'title = "Two sections"', "title = 2", "title"),
    BadPlan("half-a-mesh-round", "meshes_round = 100", "meshes_round = 100.5", "netting.0.meshes_round"),
    BadPlan("bool-as-count", "twines = 2", "twines = true", "netting.1.twines"),
    BadPlan("bool-in-list", CATCH, "filled_meshes = [20, true]", "catch.filled_meshes.1"),
    BadPlan("table-as-number", TOW, "tow = 1.0\n", "tow"),
    BadPlan("list-in-list", CATCH, "filled_meshes = [[20]]", "catch.filled_meshes.0"),
    BadPlan("half-a-bar-a-side", "bars_per_side = 1", "bars_per_side = 1.0", "model.bars_per_side"),
    # out of range
    BadPlan("empty-title", '"Two sections"', '""', "title"),
    BadPlan("nan", "radius_m = 0.30", "radius_m = nan", "entry.radius_m"),
    BadPlan("infinite", "axial_stiffness_n = 1000.0", "axial_stiffness_n = inf", "netting.0.axial_stiffness_n"),
    BadPlan("huge-whole-number", "radius_m = 0.30", f"radius_m = 1{'0' * 400}", "entry.radius_m"),
    BadPlan("number-too-long-to-print", "radius_m = 0.30", f"radius_m = 0x{'f' * 9000}", "entry.radius_m"),
    BadPlan("no-speed-in-list", "[1.0, 1.5]", "[]", "tow.speed_m_s"),
    BadPlan("standing-still", "[1.0, 1.5]", "0.0", "tow.speed_m_s"),
    BadPlan("one-speed-negative", "[1.0, 1.5]", "[1.0, -1.5]", "tow.speed_m_s.1"),
    BadPlan("as-good-as-standing-still", "[1.0, 1.5]", "1e-9", "tow.speed_m_s"),
    BadPlan("speed-in-cm-s", "[1.0, 1.5]", "100.0", "tow.speed_m_s"),
    BadPlan("density-in-g-cm3", "1026.0", "1.026", "tow.water_density_kg_m3"),
    BadPlan("two-meshes-round", "meshes_round = 100", "meshes_round = 2", "netting.0.meshes_round"),
    BadPlan("no-mesh-long", "meshes_long = 40", "meshes_long = 0", "netting.0.meshes_long"),
    BadPlan("negative-bar", "bar_mm = 40.0", "bar_mm = -40.0", "netting.0.bar_mm"),
    BadPlan("negative-knot", "knot_mm = 10.0", "knot_mm = -1.0", "netting.1.knot_mm"),
    BadPlan("strap-on-the-codline", "meshes_from_codline = 30", "meshes_from_codline = 0", STRAP),
    BadPlan("strap-in-mm", "length_m = 3.5", "length_m = 3500", "strap.0.length_m"),
    BadPlan("triple-twine", "twines = 2", "twines = 3", "netting.1.twines"),
    BadPlan("no-stiffness-at-all", "stiffness_n = 1000.0", "stiffness_n = 0.0", "netting.0.axial_stiffness_n"),
    BadPlan("negative-bending", "= 1e-4", "= -1e-4", "netting.0.bending_stiffness_n_m2"),
    BadPlan("rest-beyond-open", "_deg = 20.0", "_deg = 180.0", "netting.0.rest_opening_deg"),
    BadPlan("unknown-mesh", '"t90"', '"T90"', "netting.1.mesh"),
    BadPlan("unknown-pressure", '"uniform"', '"cone"', "catch.pressure"),
    BadPlan("unknown-law", '"le-bris-1999"', '"le-bris"', "drag.law"),
    BadPlan("unknown-fidelity", '"globalised"', '"best"', "model.fidelity"),
    BadPlan("unknown-method", 'method = "auto"', 'method = "magic"', "model.method"),
    BadPlan("unknown-damping", '"kinetic"', '"none"', "model.damping"),
    BadPlan("negative-drag", "normal = 1.36", "normal = -1.36", "drag.normal"),
    BadPlan("empty-bag", CATCH, "filled_meshes = 0", "catch.filled_meshes"),
    BadPlan("three-bars-a-side", "bars_per_side = 1", "bars_per_side = 3", "model.bars_per_side"),
    BadPlan("tolerance-too-loose", "1e-6", "0.5", "model.tolerance"),
    BadPlan("tolerance-beyond-round-off", "1e-6", "1e-15", "model.tolerance"),
    BadPlan("name-of-two-lines", "twines = 1", 'twines = 1\nname = "aft\\nend"', "netting.0.name"),
    BadPlan("name-with-a-blank-behind", "twines = 1", 'twines = 1\nname = "aft "', "netting.0.name"),
    # contradictions
    BadPlan("name-is-the-number-of-another", "twines = 1", 'twines = 1\nname = "2"', "netting.0.name"),
    BadPlan("bar-and-mesh", "bar_mm = 40.0", "bar_mm = 40.0\nmesh_mm = 90.0", "netting.0.mesh_mm"),
    BadPlan("mesh-all-knot", "mesh_mm = 100.0", "mesh_mm = 20.0", "netting.1.mesh_mm"),
    BadPlan("twine-thicker-than-bar", "twine_mm = 4.0", "twine_mm = 40.0", "netting.1.twine_mm"),
    BadPlan("two-twines-wider-than-bar", "twine_mm = 4.0", "twine_mm = 20.0", "netting.1.twine_mm"),
    BadPlan("knot-longer-than-bar", "knot_mm = 5.0", "knot_mm = 40.1", "netting.0.knot_mm"),
    BadPlan("square-with-knot", '"diamond"', '"square"', "netting.0.knot_mm"),
    BadPlan("two-catches", CATCH, f"{CATCH}\nvolume_m3 = 0.1", "catch.volume_m3"),
    BadPlan("coefficient-of-sphere", '"uniform"', '"sphere"', "catch.coefficient"),
    BadPlan("curve-for-uniform", "coefficient = 1.3", 'sphere_cp_csv = "cp.csv"', "catch.sphere_cp_csv"),
    BadPlan(
        "curve-not-there",
        'pressure = "uniform"\ncoefficient = 1.3',
        'sphere_cp_csv = "no_such_cp.csv"',
        "catch.sphere_cp_csv",
    ),
    BadPlan(
        "curve-with-a-name-no-file-can-have",
        'pressure = "uniform"\ncoefficient = 1.3',
        f'sphere_cp_csv = "{"x" * 5000}"',
        "catch.sphere_cp_csv",
    ),
    BadPlan("hoop-wider-than-netting", "radius_m = 0.30", "radius_m = 1.28", "entry.radius_m"),
    BadPlan("more-filled-than-there-is", CATCH, "filled_meshes = [20, 101]", "catch.filled_meshes.1"),
    BadPlan("front-ahead-of-entry", CATCH, "front_from_codline_m = 8.5", "catch.front_from_codline_m"),
    BadPlan("volume-in-litres", CATCH, "volume_m3 = [0.2, 200]", "catch.volume_m3.1"),
    BadPlan("mass-in-grams", CATCH, "mass_kg = 500000", "catch.mass_kg"),
    BadPlan("globalisation-divides-not", "globalisation = 10", "globalisation = 4", "model.globalisation"),
    BadPlan("globalised-to-two-round", "globalisation = 10", "globalisation = 20", "model.globalisation"),
    BadPlan("strap-between-two-rows", "meshes_from_codline = 30", "meshes_from_codline = 30.25", STRAP),
    BadPlan("strap-on-the-entry", "meshes_from_codline = 30", "meshes_from_codline = 100", STRAP),
    BadPlan("two-straps-on-a-row", "[catch]", f"{SECOND_STRAP}\n[catch]", "strap.1.meshes_from_codline"),
    BadPlan("strap-on-no-merged-row", "meshes_from_codline = 30", "meshes_from_codline = 31", "model.globalisation"),
    BadPlan("globalised-sector", GLOBALISED, GLOBALISED.replace("globalised", "sector"), "model.globalisation"),
    BadPlan("globalised-by-default", GLOBALISED, "globalisation = 10", "model.globalisation"),
    # panels, cuts, selvedges
    sewn("three-panels", "panels = 3", "panels"),
    sewn("panels-that-share-no-meshes-evenly", "panels = 4\nmeshes_round_aft = 70", "meshes_round_aft"),
    sewn("cut-and-counts-contradict", 'panels = 2\nmeshes_round_aft = 60\ncut = "AB"', "cut"),
    sewn("cut-that-no-cutter-writes", 'cut = "2N"', "cut"),
    sewn("cut-that-leaves-nothing", 'panels = 4\ncut = "AB"', "cut"),
    sewn("tapers-to-two-meshes", "meshes_round_aft = 2", "meshes_round_aft"),
    sewn("more-selvedge-than-panel", "panels = 2\nselvedge_meshes = 25", "selvedge_meshes"),
    sewn("part-of-a-mesh-in-the-selvedge", "panels = 2\nselvedge_meshes = 2.5", "selvedge_meshes"),
    # twine and entry
    BadPlan("unknown-material", "twines = 1", 'twines = 1\nmaterial = "nylon"', "netting.0.material"),
    BadPlan(
        "more-fibre-than-the-twine-holds",
        "twines = 1",
        'twines = 1\nmaterial = "PE"\nrunnage_m_kg = 0.1',
        "netting.0.runnage_m_kg",
    ),
    BadPlan("twine-number-of-no-yarns", "twines = 1", 'twines = 1\ntwine_number = "thick"', "netting.0.twine_number"),
    BadPlan(
        "twine-number-of-too-many-yarns",
        "twines = 1",
        f'twines = 1\nmaterial = "PA"\ntwine_number = "210/{"9" * 400}"',
        "netting.0.twine_number",
    ),
    BadPlan("twine-of-nothing", "twines = 1", 'twines = 1\nmaterial = "PE"\nrtex = 1e-9', "netting.0.rtex"),
    BadPlan("rtex-and-runnage", "twines = 1", "twines = 1\nrtex = 4000\nrunnage_m_kg = 250", "netting.0.runnage_m_kg"),
    BadPlan("thickness-of-no-material", "twine_mm = 3.0", "rtex = 4000", "netting.0.twine_mm"),
    BadPlan(
        "gauge-and-full-mesh", "mesh_mm = 100.0", "mesh_mm = 100.0\ninside_mesh_mm = 90.0", "netting.1.inside_mesh_mm"
    ),
    BadPlan("hung-wider-than-stretched", "radius_m = 0.30", "hanging_ratio = 1.2", "entry.hanging_ratio"),
    BadPlan("hoop-and-hanging-ratio", "radius_m = 0.30", "radius_m = 0.30\nhanging_ratio = 0.3", "entry.hanging_ratio"),
    # ropes
    roped("rope-behind-the-codline", "meshes_from_codline = [-5, 30]", "meshes_from_codline.0"),
    roped("rope-ahead-of-the-entry", "meshes_from_codline = [0, 101]", "meshes_from_codline.1"),
    roped("rope-from-fore-to-aft", "meshes_from_codline = [30, 10]", "meshes_from_codline"),
    roped("rope-between-two-rows", "meshes_from_codline = [0, 30.3]", "meshes_from_codline.1"),
    roped("rope-with-one-end", "meshes_from_codline = [30]", "meshes_from_codline.1"),
    roped("no-ropes", "number = 0", "number"),
    roped("more-ropes-than-meshes", "number = 60", "number"),
    roped("shortening-in-per-cent", "shortening = 10", "shortening"),
    roped("rope-without-stiffness", "axial_stiffness_n = 0", "axial_stiffness_n"),
    roped("rope-with-density-and-no-diameter", "density_kg_m3 = 950", "density_kg_m3"),
    roped("rope-of-no-kind", 'kind = "belly"', "kind"),
    # straps
    BadPlan(
        "strap-with-two-lengths",
        "length_m = 3.5",
        "length_m = 3.5\ncircumference_share = 0.5",
        "strap.0.circumference_share",
    ),
    BadPlan("strap-longer-than-round", "length_m = 3.5", "circumference_share = 1.5", "strap.0.circumference_share"),
    BadPlan("straps-on-each-other", "length_m = 3.5", "length_m = 3.5\nspacing_meshes = 0", "strap.0.spacing_meshes"),
    # windows
    windowed("window-in-no-section", 'netting = "belly"', "netting"),
    windowed("window-in-no-panel", 'panel = "top"', "panel"),
    windowed("window-behind-the-codline", "meshes_from_codline = [-10, 10]", "meshes_from_codline.0"),
    windowed("window-in-two-sections", "meshes_from_codline = [50, 70]", "meshes_from_codline.1"),
    windowed("window-from-fore-to-aft", "meshes_from_codline = [50, 40]", "meshes_from_codline"),
    windowed("window-wider-than-netting", "meshes_across = 51", "meshes_across"),
    windowed("window-of-panels", "panels = 2", "panels"),
    windowed("window-without-its-place", "meshes_fron_codline = [40, 50]", "meshes_fron_codline"),
    BadPlan("windows-over-one-another", "[catch]", f"{2 * ONE_WINDOW}[catch]", "window.1.meshes_from_codline"),
    BadPlan("strap-through-a-window", "[catch]", f"{ONE_LOWER}[catch]", STRAP),
    BadPlan("rope-through-a-window", "[catch]", f"{FOUR_ROPES}{ONE_WINDOW}[catch]", "rope.0.number"),
]


def assert_is_one_clear_line(error: InputError, path: object) -> None:
    message = str(error)
    assert len(message.splitlines()) == 1
    assert message.isprintable()
    assert message.startswith(f"{path}: ")
    assert error.file == str(path)
    assert " ".join(error.key.split()) in message
    assert error.allowed
    assert "pydantic" not in message
