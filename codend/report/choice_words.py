"""Why a model is enough, in words."""

from codend.bag.near_ratio import NearRatio
from codend.equilibrium.fidelity import Choice, Reason
from codend.report.style import listed


def reason_text(choice: Choice) -> str:
    """Why the model was chosen, and what it costs in accuracy and time."""
    weighed = _weighed(choice)
    match choice.reason:
        case Reason.ASKED:
            said = f"Asked for: {_model(choice)}"
            if choice.weight_matters and not choice.sees_weight:
                said += f"; {_left_out(weighed)}"
        case Reason.ROPES:
            alike = "The plan is the same all round but for equal ropes or seams"
            said = f"{alike}: {_sector(choice)}, as they repeat, {_exact(choice)}"
        case Reason.BETWEEN_ROPES:
            said = (
                "Ropes as they are with fewer, larger meshes between them are near enough for the accuracy in opening "
                f"that is asked for: one of {choice.order} equal sectors, {_by(choice)} meshes merged into one, "
                f"which costs {100.0 * choice.drag_error:.2g} % in drag"
            )
        case Reason.SMEARED:
            said = (
                "Ropes smeared over all meshes round are near enough for the accuracy in opening that is asked for: "
                f"{_smeared(choice)}, which costs {100.0 * choice.drag_error:.2g} % in drag"
            )
        case Reason.WINDOW:
            said = f"A window lies somewhere round the net: {_merged(choice)}"
        case Reason.NO_WEIGHT:
            light = "no twine density is given, so wet weight is left out, and the catch is as dense as the water"
            said = f"The plan is the same all round and {light}: {_sector_enough(choice)}"
        case Reason.LITTLE_WEIGHT:
            said = f"The plan is the same all round and {weighed}, is negligible: {_sector_enough(choice)}"
        case Reason.TIPS:
            said = (
                "Rings go slack ahead of the catch, and weight, however little, may tip the bag at its "
                f"hoop ({weighed}): the full net"
            )
        case Reason.WEIGHT | Reason.TOO_HEAVY_TO_GLOBALISE:
            model = _merged(choice)
            if choice.reason is Reason.TOO_HEAVY_TO_GLOBALISE:
                model = "the full net, for merged meshes may bear so much of it otherwise"
            said = f"Wet weight breaks the symmetry ({weighed}): {model}"
    return f"{said}.{_time(choice)}"


def _left_out(weighed: str) -> str:
    return f"it leaves out the wet weight, which here matters ({weighed})"


def _merged(choice: Choice) -> str:
    """The full net, how many of its meshes are merged, and what that costs."""
    merged = choice.globalisation > 1
    model = f"the full net, {_by(choice)} meshes merged into one" if merged else "the full net"
    allowed = f"{100.0 * choice.drag_error:.2g} % in drag where {100.0 * choice.accuracy:g} % is allowed"
    return f"{model}, which costs {allowed}"


def _weighed(choice: Choice) -> str:
    """What net and catch weigh in water, over the drag."""
    share = f"{100.0 * choice.weight_over_drag:.2g} % of the drag"
    if choice.catch_weight_n == 0.0:
        return f"wet weight {choice.weight_n:.3g} N, {share} of the smallest catch"
    net = f" and of the net {choice.weight_n:.3g} N" if choice.weight_n > 0.0 else ""
    return f"wet weight of the catch {choice.catch_weight_n:.3g} N{net}, {share} at the lowest speed"


def _model(choice: Choice) -> str:
    match choice.fidelity:
        case "sector":
            return _sector(choice)
        case "smeared":
            return f"{_smeared(choice)}, with its share of the ropes"
        case "meridian":
            return "the netting as a membrane, the same all round"
        case "globalised":
            return f"the full net, {_by(choice)} real meshes merged into one"
        case _:
            return "every mesh of the real net"


def _by(choice: Choice) -> str:
    """How many meshes are merged into one, each way."""
    return f"{choice.globalisation:.3g} x {choice.globalisation:.3g}"


def _sector(choice: Choice) -> str:
    """The narrowest sector: of how many, and how many meshes of each section make it if it is not a single one."""
    if choice.order == 1:
        return f"the full net (its mesh counts {listed(choice.meshes_round)} have no common divisor)"
    wide = [count // choice.order for count in choice.meshes_round]
    meshes = "" if wide == [1] else f", {listed(wide)} meshes wide,"
    return f"one of {choice.order} equal sectors{meshes} of the real net"


def _smeared(choice: Choice) -> str:
    """What ropes are smeared over."""
    if choice.near is None:
        return "a sector one mesh wide"
    wide, stands_for = width_and_count(choice.near)
    return f"a sector {wide} meshes wide, as of {stands_for} meshes round, that tapers along a seam of its own"


def width_and_count(near: NearRatio) -> tuple[str, str]:
    """How many meshes a sector of nearly the ratio of the counts is wide, and of how many round it is one."""
    wide = tuple(dict.fromkeys(near.columns))
    return listed(wide), listed([f"{near.order * columns:.1f}" for columns in wide])


def _sector_enough(choice: Choice) -> str:
    """That the sector is exact, or why another stands for it and what that costs."""
    near = choice.near
    if near is None:
        return f"{_sector(choice)} {_exact(choice)}"
    wide, stands_for = width_and_count(near)
    return (
        f"{_sector(choice)} would be exact, but take minutes; in its place stands one {wide} meshes "
        f"wide, as of {stands_for} meshes round, which takes seconds and costs about {100.0 * choice.drag_error:.2g} % "
        f"in drag where {100.0 * choice.accuracy:g} % is allowed"
    )


def _exact(choice: Choice) -> str:
    """For what the sector is exact."""
    if choice.layered:
        return "is as good as the whole net, though not exact: its layers are taken to move with the netting below"
    return "is exact"


def _time(choice: Choice) -> str:
    """What a large model costs in time; empty for others."""
    if not choice.slow:
        return ""
    wide = choice.fidelity == "sector" and len(choice.meshes_round) > 1
    narrower = "; meshes round with a larger common divisor make a narrower sector" if wide else ""
    quick = ""
    if choice.real_ropes:
        quick = (
            " For a quick look model.opening_accuracy_deg lets ropes be smeared, or meshes between them be merged, "
            "which takes about a second."
        )
    return f" Its {choice.knots} knots take seconds to minutes a case{narrower}.{quick}"
