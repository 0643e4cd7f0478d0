"""Best settings of one design in arbitrary precision, and the arithmetic to evaluate a program in it.

Nothing of `uwopt` takes part: the window of X = light * level * time / N_w^2 comes from bisections of the noise
budget (physics page, section 6), the least power and the greatest SNR from what is monotone in X.

A design here is one lamp over one floor: `signal_e` electrons per lm s at N_w = 1, no dark current, no mean level.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import mpmath as mp

CONTINUOUS, PULSED, FLASH = 0, 1, 2
DIGITS = 50


@dataclass(frozen=True)
class Truth:
    """One scene's numbers, as floats; their values are taken as exact."""

    kind: int
    signal_e: float
    read_noise_e: float
    gain_dn_per_e: float
    max_gain: float
    full_scale_dn: float
    well_e: float
    prnu_frac: float
    highlight_ratio: float
    min_snr: float
    light_lm: float
    power_w: float  # at full; of a flash pulse energy times rate
    rate_hz: float
    time_min_s: float
    time_max_s: float
    min_level: float
    max_level: float
    n_low: float
    n_high: float
    working_factor: float

    def gain(self, mu: Any) -> Any:
        """The highest gain [DN/e] that does not saturate."""
        most = mp.mpf(self.full_scale_dn) / mp.mpf(self.highlight_ratio) / mu
        least = mp.mpf(self.gain_dn_per_e)
        return max(least, min(least * mp.mpf(self.max_gain), most))

    def snr(self, mu: Any) -> Any:
        """SNR of so many electrons at that gain, equation (7)."""
        variance = mp.mpf(self.read_noise_e) ** 2 + 1 / (12 * self.gain(mu) ** 2) + mu
        return mu / mp.sqrt(variance + (mp.mpf(self.prnu_frac) * mu) ** 2)

    def most_e(self) -> Any:
        """Most electrons: full well and full scale at the lowest gain."""
        ratio = mp.mpf(self.highlight_ratio)
        return min(
            mp.mpf(self.well_e) / ratio, mp.mpf(self.full_scale_dn) / ratio / mp.mpf(self.gain_dn_per_e)
        )

    def least_e(self) -> Any:
        """Fewest electrons with the wanted SNR; None where the most have too little."""
        high = self.most_e()
        if self.snr(high) < self.min_snr:
            return None
        return root(lambda mu: self.snr(mu) - mp.mpf(self.min_snr), high)

    def square(self, n: Any) -> Any:
        """N_w^2."""
        return (mp.mpf(n) * mp.mpf(self.working_factor)) ** 2

    def widest(self) -> Any:
        """The smallest f-number at which the dimmest, shortest light does not saturate; None: there is none."""
        least = (
            mp.mpf(self.signal_e) * mp.mpf(self.light_lm) * mp.mpf(self.min_level) * mp.mpf(self.time_min_s)
        )
        n = max(mp.mpf(self.n_low), mp.sqrt(least / self.most_e()) / mp.mpf(self.working_factor))
        return n if n <= mp.mpf(self.n_high) else None

    def electrons(self, n: Any, level: Any, time_s: Any) -> Any:
        """Electrons at settings."""
        return mp.mpf(self.signal_e) * mp.mpf(self.light_lm) * level * time_s / self.square(n)

    def least_power(self, n: Any) -> Any:
        """Least power at an f-number; None where no light there is enough."""
        least = self.least_e()
        if least is None:
            return None
        need = least * self.square(n) / (mp.mpf(self.signal_e) * mp.mpf(self.light_lm))  # level * time
        if need > mp.mpf(self.max_level) * mp.mpf(self.time_max_s):
            return None
        if self.kind == PULSED:
            return (
                mp.mpf(self.power_w)
                * mp.mpf(self.rate_hz)
                * max(need, mp.mpf(self.min_level) * mp.mpf(self.time_min_s))
            )
        return mp.mpf(self.power_w) * max(need / mp.mpf(self.time_max_s), mp.mpf(self.min_level))


def root(rising: Callable[[Any], Any], high: Any) -> Any:
    """Where a rising function crosses 0 below `high`, by bisection of the logarithm."""
    low, high = mp.log(high) - 200, mp.log(high)
    for _ in range(int(DIGITS * 3.5)):
        middle = (low + high) / 2
        low, high = (low, middle) if rising(mp.exp(middle)) >= 0 else (middle, high)
    return mp.exp(high)


def least_power_w(scenes: list[Truth]) -> Any:
    """Least light power of the worst scene at a common f-number; None where nothing is feasible.

    More f-number takes more light everywhere, so the smallest that fits all is best.
    """
    with mp.workdps(DIGITS):
        widest = [scene.widest() for scene in scenes]
        if any(n is None for n in widest):
            return None
        n = max(widest)
        if any(n > mp.mpf(scene.n_high) for scene in scenes):
            return None
        powers = [scene.least_power(n) for scene in scenes]
        return None if any(power is None for power in powers) else max(powers)


def greatest_snr(scene: Truth) -> Any:
    """Highest SNR: as much light as lamp, well and scale take; None where that is too little or too much."""
    with mp.workdps(DIGITS):
        n = scene.widest()
        if n is None:
            return None
        most = scene.electrons(n, mp.mpf(scene.max_level), mp.mpf(scene.time_max_s))
        reached = scene.snr(min(most, scene.most_e()))
        return reached if reached >= mp.mpf(scene.min_snr) else None


def least_sum(scene: Truth, power_weight: float, snr_weight: float) -> Any:
    """Least of power_weight * P - snr_weight * SNR in dB, a lamp that burns: P is linear in mu, the rest rises.

    Found by thirds over ln mu: P is convex in it and -ln SNR too.
    """
    with mp.workdps(DIGITS):
        n, least = scene.widest(), scene.least_e()
        if n is None or least is None:
            return None
        per_watt = scene.electrons(n, 1, mp.mpf(scene.time_max_s)) / mp.mpf(scene.power_w)

        def total(log_mu: Any) -> Any:
            mu = mp.exp(log_mu)
            watts = max(mu / per_watt, mp.mpf(scene.power_w) * mp.mpf(scene.min_level))
            return mp.mpf(power_weight) * watts - mp.mpf(snr_weight) * 20 * mp.log10(scene.snr(mu))

        top = min(scene.most_e(), per_watt * mp.mpf(scene.power_w) * mp.mpf(scene.max_level))
        low, high = mp.log(least), mp.log(top)
        if low > high:
            return None
        for _ in range(300):
            third = (high - low) / 3
            low, high = (
                (low, high - third) if total(low + third) < total(high - third) else (low + third, high)
            )
        return total((low + high) / 2)


class Exact:
    """A number of arbitrary precision that NumPy's elementary functions take."""

    def __init__(self, value: Any):
        self.value = value.value if isinstance(value, Exact) else mp.mpf(value)

    def _with(self, other: Any, deed: Callable[[Any, Any], Any]) -> Exact:
        return Exact(deed(self.value, Exact(other).value))

    def __add__(self, other: Any) -> Exact:
        return self._with(other, lambda a, b: a + b)

    def __sub__(self, other: Any) -> Exact:
        return self._with(other, lambda a, b: a - b)

    def __rsub__(self, other: Any) -> Exact:
        return self._with(other, lambda a, b: b - a)

    def __mul__(self, other: Any) -> Exact:
        return self._with(other, lambda a, b: a * b)

    def __truediv__(self, other: Any) -> Exact:
        return self._with(other, lambda a, b: a / b)

    def __rtruediv__(self, other: Any) -> Exact:
        return self._with(other, lambda a, b: b / a)

    def __pow__(self, other: Any) -> Exact:
        return self._with(other, lambda a, b: a**b)

    def __neg__(self) -> Exact:
        return Exact(-self.value)

    __radd__, __rmul__ = __add__, __mul__

    def exp(self) -> Exact:
        return Exact(mp.exp(self.value))

    def log(self) -> Exact:
        return Exact(mp.log(self.value))

    def sqrt(self) -> Exact:
        return Exact(mp.sqrt(self.value))

    def square(self) -> Exact:
        return Exact(self.value**2)


def exact_rules(program: Any, x: Any) -> tuple[list[Any], list[Any]]:
    """A program's objective, inequalities and equalities at a point, and their gradients by central differences.

    Steps of 1e-30 in 100 digits leave errors of 1e-60.
    """
    with mp.workdps(100):
        step = mp.mpf("1e-30")

        def at(shift: int, by: Any) -> list[Any]:
            point = [Exact(mp.mpf(float(v)) + (by if i == shift else 0)) for i, v in enumerate(x)]
            found = program.rules(point)
            return [Exact(v).value for v in (found.objective, *found.inequalities.values(), *found.equalities.values())]

        values = at(-1, 0)
        columns = [
            [(up - down) / (2 * step) for up, down in zip(at(i, step), at(i, -step), strict=True)]
            for i in range(len(x))
        ]
        return values, [list(row) for row in zip(*columns, strict=True)] if columns else [[] for _ in values]


__all__ = ["Truth", "exact_rules", "greatest_snr", "least_power_w", "least_sum", "replace"]
