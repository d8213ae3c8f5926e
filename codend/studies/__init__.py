"""Many equilibria: cases of a plan, sweeps over plans, one mesh pulled open, comparisons, speed against accuracy."""
