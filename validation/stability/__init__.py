"""Stability maps: where each method finds the right answer, where it fails and says so, and that none lies."""

from validation.stability.report import section

__all__ = ["section"]
