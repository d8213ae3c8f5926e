"""Names of the numbers of a species, by which kernels find their places."""

PARAMETERS = (
    "section.height_per_length",
    "section.width_per_length",
    "section.exponent",
    "section.height_compression",
    "section.width_compression",
    "spread.size",
    "spread.shape",
    "behaviour.contact",
    "behaviour.attempts",
    "behaviour.rows_ahead",
    "behaviour.rotation_deg",
    "behaviour.push_force_n",
    "behaviour.push_exponent",
    "behaviour.push_length_cm",
    "haul.catch_growth",
)
"""Numbers that retention depends on, in the order of ``Species.values``."""
