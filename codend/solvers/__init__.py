"""Solvers, one file a method: each takes a problem (a net under loads) and knows nothing of codends."""
