"""Work against precision: the error in drag, opening and volume of every method and model, against its solve time."""

from validation.work_precision.report import section

__all__ = ["section"]
