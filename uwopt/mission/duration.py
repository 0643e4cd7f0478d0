"""What a mission uses up over its duration: energy and storage, from means over its scenes.

The one place that knows how shares of time weigh scenes, and which mean power and data rate a limit of energy or
storage leaves. No arrays are made here: means are sums of products, of numbers or of arrays alike.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from uwopt.mission.mission import Mission
from uwopt.units import S_PER_H

MB_PER_GB = 1000.0


@dataclass(frozen=True)
class Duration:
    """How long a mission takes, how its scenes share that time, and what it may use up; inf: no limit."""

    shares: tuple[float, ...]  # of the time, by scene; they sum to 1
    duration_h: float | None
    battery_wh: float | None
    energy_wh: float  # limits
    storage_gb: float
    energy_reserve_wh: float = 0.0  # kept of what is asked, which the limit is without

    @staticmethod
    def of(mission: Mission) -> Duration:
        """As the mission says."""
        vehicle, limits = mission.vehicle, mission.limits
        asked_wh, storage_gb = (math.inf if x is None else x for x in (limits.energy_wh, limits.storage_gb))
        held_wh = asked_wh
        if vehicle.supply == "battery" and vehicle.duration_h and vehicle.battery_wh:
            asked_wh = min(asked_wh, vehicle.battery_wh)  # what the system brings along is all there is
            held_wh = min(asked_wh, (1.0 - mission.reserve.energy) * vehicle.battery_wh)
        kept_wh = asked_wh - held_wh if held_wh < asked_wh else 0.0
        return Duration(
            mission.time_shares, vehicle.duration_h, vehicle.battery_wh, held_wh, storage_gb, energy_reserve_wh=kept_wh
        )

    def mean(self, by_scene: Sequence[Any]) -> Any:
        """Mean over the time of a figure that each scene has one of."""
        return sum(share * value for share, value in zip(self.shares, by_scene, strict=True))

    # ------------------------------------------------------------ limits as means

    @property
    def mean_power_limit_w(self) -> float:
        """Highest mean power of the whole mission."""
        return self.energy_wh / self.duration_h if self.duration_h else math.inf

    @property
    def mean_data_limit_mb_s(self) -> float:
        """Highest mean data rate of the whole mission, all cameras together."""
        return float(self.mean_rate_into(self.storage_gb))

    def mean_rate_into(self, room_gb: Any) -> Any:
        """Highest mean data rate [10^6 byte/s] that so much room holds; inf without a duration."""
        return room_gb * MB_PER_GB / (self.duration_h * S_PER_H) if self.duration_h else math.inf

    @property
    def scene_power_limit_w(self) -> float:
        """What the energy leaves for any one scene: its mean is the mission's where there is no other."""
        return self.mean_power_limit_w if len(self.shares) == 1 else math.inf

    @property
    def over_scenes(self) -> bool:
        """Whether the energy is limited over several scenes together."""
        return len(self.shares) > 1 and math.isfinite(self.mean_power_limit_w)

    # ------------------------------------------------------------ figures

    def energy_of(self, mean_power_w: Any) -> Any:
        """Energy [Wh] that a mean power takes; None without a duration."""
        return None if self.duration_h is None else mean_power_w * self.duration_h

    def storage_of(self, mean_data_mb_s: Any) -> Any:
        """Storage [GB, 10^9 byte] that a mean data rate fills; None without a duration."""
        return None if self.duration_h is None else mean_data_mb_s * self.duration_h * S_PER_H / MB_PER_GB

    def endurance_h(self, mean_power_w: float) -> float | None:
        """Hours that the battery lasts at a mean power; None without a battery, inf where nothing is drawn."""
        if self.battery_wh is None:
            return None
        return self.battery_wh / mean_power_w if mean_power_w > 0 else math.inf
