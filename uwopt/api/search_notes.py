"""What a result notes of the search behind it: what had to yield, what is still open, what was cut short and why."""

from __future__ import annotations

import time
from collections.abc import Sequence

from uwopt.api.common import beyond_cap
from uwopt.deadline import Deadline, longer_s
from uwopt.forward.problem import Problem
from uwopt.mission.mission import Mission
from uwopt.results.design import Design, Note
from uwopt.results.result import Certificate, Result
from uwopt.solvers.recommend import Sought


def gain_warnings(mission: Mission, problem: Problem, designs: Sequence[Design]) -> list[Note]:
    """That nothing fits below the gain that is recommended, where its cap had to yield: of several designs the most."""
    cap_db = mission.reserve.max_gain_db
    if cap_db is None or not designs or problem.mission.reserve.max_gain_db is not None:
        return []
    gain_db = max((scene.settings.get("gain_db") or 0.0) for design in designs for scene in design.as_set.scenes)
    text = f"{beyond_cap(gain_db, cap_db)}, below which nothing fits: light is out of reach"
    return [Note("gain_cap", "reserve.max_gain_db", text)]


def on_sale_warnings(sought: Sought, used: Sought) -> list[Note]:
    """That parts on sale are proven not to fit, where the search with parts to be made was cut short."""
    if used is sought or used.outcome.complete or not sought.outcome.complete:
        return []
    text = "no combination of parts on sale fits, which is proven; the search with parts to be made was cut short"
    return [Note("parts_on_sale", "catalog.generic", text)]


def gap_warnings(proof: Certificate) -> list[Note]:
    """That the bounds on settings without a closed form did not close."""
    share = 100.0 * (proof.gap_rel or 0.0)
    text = f"no combination is more than {share:.2g} % better, but the settings' bounds do not close further"
    return [Note("gap", "objective", text)]


def interruption_warnings(sought: Sought) -> list[Note]:
    """That the search was interrupted, if it was."""
    text = "interrupted: the best found so far, without the tests of its doubts"
    if not sought.outcome.best:
        text = "interrupted before a system was found"
    return [Note("interrupted", "", text)] if sought.outcome.interrupted else []


def cut_warnings(
    what: str = "the system is proven, but not all that is usually told of it was worked out",
) -> list[Note]:
    """That what follows the proof was interrupted."""
    return [Note("interrupted", "", f"interrupted: {what}")]


def patience_warnings(patience: Deadline, seconds: float, began_s: float) -> list[Note]:
    """What an explanation left out that nobody gave a time: that the answer stands, and how to have the rest told.

    seconds : of the processor, that it had
    began_s : when the whole call was asked, on the wall's clock
    """
    if not patience.left_out:
        return []
    text = (
        f"the answer stands without what was not worked out beside it in {seconds:.2g} s; the same command with "
        f"--seconds {longer_s(time.perf_counter() - began_s, seconds)} gives it more: "
    )
    return [Note("time", "", text + "; ".join(dict.fromkeys(patience.left_out)))]


def interrupted(result: Result) -> bool:
    """Whether a person wants no more."""
    return any(warning.code == "interrupted" for warning in result.warnings)
