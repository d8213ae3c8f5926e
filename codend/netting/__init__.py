"""Netting written as nets: the lattice of knots, what joins them, straps."""
