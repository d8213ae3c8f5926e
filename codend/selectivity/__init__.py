"""Size selectivity: mesh penetration, retention curves, and curves fitted to sea-trial data.

Called, it predicts: ``codend.selectivity(study, "haddock.toml")`` is ``codend.selectivity.predicted``.
"""

import sys
from collections.abc import Sequence
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import pandas as pd

    from codend.selectivity.escape.catches import Solved


def predicted(study: "Solved | str | Path", species: str | Path | Sequence[str | Path]) -> "pd.DataFrame":
    """Which fish a codend retains: ``selectivity.csv``, a row a case and species, and one for the whole haul.

    Args:
        study: a study, or the folder of a run.
        species: the path of a species file, or several.

    Raises:
        InputError: no case was solved, or a file cannot be used.
    """
    from codend.selectivity.escape.catches import read_run, run_of
    from codend.selectivity.escape.predict import predict
    from codend.selectivity.escape.species import load_species
    from codend.selectivity.escape.tables import selectivity_table

    paths = [species] if isinstance(species, str | Path) else species
    run = read_run(study) if isinstance(study, str | Path) else run_of(study)
    return selectivity_table(predict(run, [load_species(path) for path in paths]))


class _Called(ModuleType):
    """The room as a user meets it: a package that can be called."""

    def __call__(self, study: "Solved | str | Path", species: str | Path | Sequence[str | Path]) -> "pd.DataFrame":
        return predicted(study, species)


sys.modules[__name__].__class__ = _Called
