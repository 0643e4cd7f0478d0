"""The same light by photons from the lamp: a second estimator, independent but for the steps of `walk`.

From each collision, and from each touch of the floor, the share that goes straight to the camera is added where it
falls in the image. That asks the phase function for its forward peak and is divided by the distance squared. The
tail of the latter is cut: within NEAR of the camera 1/r^2 counts with its mean over that ball, as the water there
is lit evenly. That of the former is not, so that the error of its batches is rather too small for a peaked
function. Good for a check, not for the table.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from .camera import BATCHES, Seen, View
from .lamps import MOST_STEPS, Lamp
from .walk import Water, compiled, drawn_angle, phase_at, survivor, turned

LEAST = 1e-2
NEAR = 0.04  # of the altitude


@compiled
def photon(rng: Any, water: Water, lamp: Lamp, view: View, out: Any) -> None:
    """Adds one photon to `out` (3,): signal, forward veil, backscatter."""
    turn = np.arccos(rng.random() ** (1.0 / (lamp.exponent + 1.0)))
    dx, dy, dz = turned(rng, lamp.aim_x, lamp.aim_y, lamp.aim_z, turn)
    x, y, z, weight, touched = lamp.x, lamp.y, 0.0, 1.0, False
    for _ in range(MOST_STEPS):
        way = -np.log(1.0 - rng.random()) / water.c
        lands = dz > 0.0 and way * dz >= view.floor - z
        if lands:
            way = (view.floor - z) / dz
        x, y, z = x + way * dx, y + way * dy, view.floor if lands else z + way * dz
        weight *= view.reflectance if lands else water.albedo
        r = np.sqrt(x * x + y * y + z * z)
        if z > 0.0 and abs(x) <= view.tan_x * z and abs(y) <= view.tan_y * z:
            spread = z / r / np.pi if lands else phase_at(-(x * dx + y * dy + z * dz) / r, water)
            near = NEAR * view.floor
            square = r * r if r > near else near * near / 3.0
            share = z / r / (square * 4.0 * view.tan_x * view.tan_y)  # radiance times cos^4, mean over tangents
            out[0 if lands else 1 if touched else 2] += weight * spread * np.exp(-water.c * r) * share
        weight = survivor(rng, weight, LEAST)
        if weight == 0.0 or view.floor - z > 4.0 * view.floor + 12.0 / water.c:
            break
        if lands:
            touched = True
            dz = -np.sqrt(rng.random())
            phi, sine = 2.0 * np.pi * rng.random(), np.sqrt(1.0 - dz * dz)
            dx, dy = sine * np.cos(phi), sine * np.sin(phi)
        else:
            dx, dy, dz = turned(rng, dx, dy, dz, drawn_angle(rng, water, 1.0))


@compiled
def photons(rng: Any, water: Water, lamp: Lamp, view: View, n: int, out: Any) -> None:
    """Adds n photons to `out`."""
    for _ in range(n):
        photon(rng, water, lamp, view, out)


def seen(water: Water, lamp: Lamp, view: View, n: int, seed: Any) -> Seen:
    """Image means of signal, forward veil and backscatter, as `camera.seen` gives them."""
    sums = np.zeros((BATCHES, 3))
    for k, source in enumerate(np.random.SeedSequence(seed).spawn(BATCHES)):
        photons(np.random.default_rng(source), water, lamp, view, n // BATCHES, sums[k])
    means = sums / (n // BATCHES)
    mean = means.mean(axis=0)
    error = means.std(axis=0, ddof=1) / np.sqrt(BATCHES)
    return Seen(mean, error, means.max(axis=0) / np.where(mean > 0.0, mean, 1.0))
