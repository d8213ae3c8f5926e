"""The structure: nodes, bars, facets and what holds them. Nothing of codends, loads or solvers."""
