"""What L50, SR and split depend on: formulas of the columns of a trial's table that are constant within a haul.

Formulas are those of statistics packages (`catch_kg`, `gear + catch_kg`, `gear * catch_kg`), read by `formulaic`: text
columns are factors, numbers are covariates, an intercept is always there. Internally the columns are orthogonal over
the hauls, the first constant at 1, so that its coefficient is the mean over hauls.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from codend.errors import OPTIONS, InputError

if TYPE_CHECKING:
    import pandas as pd

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Predictor:
    """Columns of a formula over H hauls.

    Attributes:
        formula: as given.
        terms: names of its q columns, "Intercept" first.
        columns: (H, q) orthogonal basis.
        to_basis: (q, q) from the formula's own columns to the basis; its inverse takes coefficients back.
        spec: what `formulaic` needs to make the columns for other values; None for a bare intercept.
    """

    formula: str
    terms: tuple[str, ...]
    columns: Array
    to_basis: Array
    spec: Any

    def at(self, frame: pd.DataFrame) -> Array:
        """(n, q) basis columns for other rows."""
        if self.spec is None:
            return np.ones((len(frame), 1))
        return np.asarray(self.spec.get_model_matrix(frame), dtype=float) @ self.to_basis


def predictor(name: str, formula: str, hauls: pd.DataFrame, source: str) -> Predictor:
    """Read a formula of the columns of `hauls`, a row a haul.

    Args:
        name: of the option, for messages.
        formula: right-hand side; "1" for the intercept alone.
        hauls: as from `FieldData.haul_columns`.
        source: of the table.

    Raises:
        InputError: no formula, a column that is not there, or terms that these hauls do not tell apart.
    """
    if formula.strip() == "1":
        return Predictor(formula, ("Intercept",), np.ones((len(hauls), 1)), np.eye(1), None)
    from formulaic import model_matrix
    from formulaic.errors import FormulaicError

    allowed = f"a formula of columns that are constant within a haul ({', '.join(map(str, hauls.columns))})"
    try:
        matrix = model_matrix(formula, hauls, na_action="raise", context=None)
    except (FormulaicError, ValueError, TypeError, NameError, SyntaxError, AttributeError) as error:
        raise _unreadable(name, formula, allowed, error) from None
    if hasattr(matrix, "lhs") or "Intercept" not in matrix.columns:
        raise InputError(OPTIONS, name, formula, f"{allowed}, with an intercept and without a left side")
    values = np.asarray(matrix, dtype=float)
    spread = np.sqrt((values**2).mean(axis=0))
    q, r = np.linalg.qr(values / np.where(spread > 0.0, spread, 1.0))
    size = np.abs(np.diagonal(r))
    if len(values) < values.shape[1] or size.min() < 1e-8 * size.max():
        rank = int(np.linalg.matrix_rank(values))
        reason = f"its {values.shape[1]} columns have rank {rank} over the {len(hauls)} hauls of {source}"
        raise InputError(OPTIONS, name, formula, "terms that differ between hauls and not all together", reason)
    sign = np.sign(q[0, 0])
    to_basis = np.linalg.inv(r * spread[None, :]) * np.sqrt(len(values)) * sign
    return Predictor(formula, tuple(map(str, matrix.columns)), values @ to_basis, to_basis, matrix.model_spec)


def columns_of(name: str, formula: str) -> list[str]:
    """Names that a formula uses; none of an empty one.

    Raises:
        InputError: it cannot be read.
    """
    from formulaic import Formula
    from formulaic.errors import FormulaicError

    try:
        return sorted(map(str, Formula(formula or "1").required_variables))
    except (FormulaicError, ValueError, SyntaxError) as error:
        raise _unreadable(name, formula, "a formula of columns, such as gear + catch_kg", error) from None


def _unreadable(name: str, formula: str, allowed: str, error: Exception) -> InputError:
    reason = str(error).split("\n", maxsplit=1)[0][:120].rstrip(".")
    return InputError(OPTIONS, name, formula, allowed, f"cannot be read: {reason}")


def averaged(one: Predictor, hauls: pd.DataFrame, values: Mapping[str, str | float]) -> Array:
    """(q,) mean of the columns over all hauls, with some of the haul's values set: x' of a prediction."""
    return np.asarray(one.at(hauls.assign(**values)).mean(axis=0))
