"""Computed codends beside a flume table: read the table, match its rows with the cases, say how far they are apart."""

from codend.studies.comparison.compare import Comparison, compare
from codend.studies.comparison.flume_table import FlumeTable, read_flume_table
from codend.studies.comparison.hoop import Hoop

__all__ = ["Comparison", "FlumeTable", "Hoop", "compare", "read_flume_table"]
