"""The meridian method: a bag of netting that is the same all round, as an axisymmetric membrane of bars."""

from codend.bag.meridian.problem import MeridianProblem, MeridianShape
from codend.bag.meridian.solve import solve_meridian, uniform_pressure_shape

__all__ = ["MeridianProblem", "MeridianShape", "solve_meridian", "uniform_pressure_shape"]
