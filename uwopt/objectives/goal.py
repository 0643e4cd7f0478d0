"""What a mission wants to be best, as an objective: the prices of the best image in the mission's currency."""

from __future__ import annotations

import math

from uwopt.catalog.money import to_currency
from uwopt.mission.best_image import BestImageGoal
from uwopt.mission.mission import Mission
from uwopt.objectives.objective import Objective

QUALITY = {"information": "information", "snr": "snr_db"}


def goal_of(mission: Mission) -> Objective:
    """The objective of a mission."""
    wanted = mission.objective
    if not isinstance(wanted, BestImageGoal):
        return Objective.of(wanted)
    prices, limits = wanted.best_image, mission.limits
    usd = to_currency(1.0, limits.currency, "USD", limits.rates)
    per_money = math.expm1(math.log1p(prices.per_100_usd) * usd / 100.0)
    return Objective.best_image(QUALITY[prices.of], per_w=prices.per_w, per_money=per_money)
