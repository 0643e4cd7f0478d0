"""What a mission wants to be best, as an objective: the prices of the best image in the mission's currency."""

from __future__ import annotations

import math

from uwopt.catalog.money import to_currency
from uwopt.mission.best_image import BestImageGoal, why_no_information
from uwopt.mission.mission import Mission
from uwopt.objectives.objective import Objective
from uwopt.results.design import SNR_INSTEAD, Note

QUALITY = {"information": "information", "snr": "snr_db"}
NAME_OF = {term: name for name, term in QUALITY.items()}


def goal_of(mission: Mission) -> Objective:
    """The objective of a mission."""
    wanted = mission.objective
    if not isinstance(wanted, BestImageGoal):
        return Objective.of(wanted)
    prices, limits = wanted.best_image, mission.limits
    usd = to_currency(1.0, limits.currency, "USD", limits.rates)
    per_money = math.expm1(math.log1p(prices.per_100_usd) * usd / 100.0)
    quality = prices.of
    if quality == "auto":
        quality = "snr" if why_no_information(mission) else "information"
    return Objective.best_image(QUALITY[quality], per_w=prices.per_w, per_money=per_money)


def taken_instead(mission: Mission) -> list[Note]:
    """That the best image is by signal to noise, where nobody chose so and information cannot be asked."""
    wanted = mission.objective
    reasons = why_no_information(mission)
    if not isinstance(wanted, BestImageGoal) or wanted.best_image.of != "auto" or not reasons:
        return []
    return [Note(SNR_INSTEAD, "objective", f"Best image is by signal to noise: {reasons[0]}")]
