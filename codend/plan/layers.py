"""Second layers of netting over a codend: strengthening and lifting bags."""

from typing import Annotated, Self

from annotated_types import Ge, Gt
from pydantic import model_validator

from codend.plan.messages import Contradiction
from codend.plan.tables import Netting, Number


class Layer(Netting):
    """An outer bag over part of the codend: joined at the codline and where it begins, and sliding on what is below."""

    meshes_from_codline: tuple[Annotated[Number, Ge(0)], Annotated[Number, Gt(0)]]
    """Where it lies, in meshes of the netting below: from the codline, 0, to the row it is laced to."""

    @model_validator(mode="after")
    def _from_the_codline(self) -> Self:
        if self.meshes_from_codline[0] != 0:
            raise Contradiction("meshes_from_codline.0", "0: a layer is gathered at the codline")
        if self.bending_stiffness_n_m2 != 0.0:
            raise Contradiction("bending_stiffness_n_m2", "0: what a layer resists opening with is left out")
        if self.tapers or self.selvedge_meshes or self.panels > 1:
            raise Contradiction("panels", "a plain tube of netting for a layer, no panels, cuts or selvedges")
        return self
