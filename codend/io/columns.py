"""Names of the columns of a run's tables, which other people's scripts rely on."""

RESULT_COLUMNS = [
    "case",
    "speed_m_s",
    "filled_meshes",
    "catch_volume_m3",
    "catch_mass_kg",
    "front_radius_m",
    "front_from_codline_m",
    "max_radius_m",
    "length_m",
    "drag_n",
    "catch_drag_n",
    "twine_drag_n",
    "entry_reaction_n",
    "opening_ahead_deg",
    "opening_force_ahead_n",
    "max_bar_tension_n",
    "drag_error_n",
    "fidelity",
    "method",
    "iterations",
    "residual",
    "converged",
    "solve_ms",
    "catch_volume_error_m3",
    "max_radius_error_m",
    "opening_ahead_error_deg",
    "drag_change_with_suction",
    "stable",
    "growing_harmonics",
    "sector_order",
    "sector_meshes",
    "folded_share",
    "turn_deg",
    "sideways_imbalance",
    "inside_mesh_mm",
    "full_mesh_mm",
    "wrinkles",
    "drag_spread_n",
    "opening_spread_deg",
    "folds",
    "opening_ahead_spread_deg",
    "opening_ahead_least_deg",
    "opening_ahead_most_deg",
    "contact_share",
    "fold_count",
    "shapes_found",
    "codline_aside_m",
]

STRAP_COLUMNS = ["max_strap_tension_n"]
"""Further columns of plans with straps."""
ROPE_COLUMNS = ["max_rope_tension_n"]
"""Further columns of plans with ropes along the netting."""
OF_ROPES = [
    "case",
    "rope",
    "number",
    "place_deg",
    "length_m",
    "max_tension_n",
    "tension_ahead_n",
    "slack_share",
    "kind",
]
"""Columns of ``ropes.csv``."""

LAYER_COLUMNS = ["layer_hoop_share", "max_layer_tension_n", "layer_opening_deg"]
LAYER_COLUMNS += ["drag_layers_free_n", "opening_ahead_layers_free_deg"]
"""Further columns of plans with second layers: share of the hoop load on the catch that they carry, largest tension of
their bars, mean opening of their meshes over the catch; drag and opening with them as nets of their own in contact."""
OF_LAYERS = ["case", "layer", "row", "meshes_from_entry", "x_m", "radius_m", "opening_deg", "opening_below_deg"]
OF_LAYERS += ["bar_tension_n", "hoop_share", "axial_share"]
"""Columns of ``layers.csv``."""

REASON = "reason"
"""Column of a study's table that says why a case was not solved."""
TEXT_COLUMNS = ("design", "fidelity", "method", "stable", "growing_harmonics", "wrinkles", REASON)
"""Those of a study's table that hold text, also where no row has one."""

SECTION = "section"
PLACE = [SECTION, "meshes_from_entry"]
"""Name or number of the section, and the place in real meshes, however many are merged: of a row of knots in
``profile.csv``, of the middle of a mesh in ``meshes.csv``."""
OF_MESHES = ["opening_deg", "bar_tension_n", "opening_force_n", "pressure_pa"]
SIZES = ["inside_mesh_mm", "full_mesh_mm"]
"""What a gauge measures, and knot centre to knot centre: in ``results.csv`` of the meshes just ahead of the catch."""
PROFILE_COLUMNS = ["case", "row", *PLACE, "x_m", "radius_m", *OF_MESHES, *SIZES]
PANEL = "panel"
"""Panel that a mesh is of, by name."""
ALL_PANELS = "all"
"""Where less than a panel is modelled, for all are alike."""
MESH_COLUMNS = ["case", "row", "mesh", *PLACE, "x_m", "y_m", "z_m", *OF_MESHES, *SIZES, PANEL]

OPENING_FORCE_COLUMNS = [
    "case",
    "speed_m_s",
    "filled_meshes",
    "meshes_from_entry",
    "opening_deg",
    "wanted_opening_deg",
    "opening_force_alone_n",
    "opening_force_in_net_n",
    "opening_force_in_net_error_n",
    "sectors",
    "slack_bars",
    "residual",
    "converged",
]

ERRORS = {
    "drag_n": "drag_error_n",
    "catch_volume_m3": "catch_volume_error_m3",
    "max_radius_m": "max_radius_error_m",
    "opening_ahead_deg": "opening_ahead_error_deg",
    "l50_cm": "l50_opening_error_cm",
    "sr_cm": "sr_opening_error_cm",
}
"""Column of the error of what a case tells."""


def error_of(quantity: str) -> str:
    """Column of a quantity's error, of the same species."""
    column, space, species = quantity.partition(" ")
    return ERRORS[column] + space + species
