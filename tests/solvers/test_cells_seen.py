"""Light in cells of the floor: quadrants that a lamp sees alike are taken once, and counted as often as they are."""

from __future__ import annotations

import math

import numpy as np
import pytest

from uwopt.model.beam import Beam
from uwopt.model.imaging import Lamps
from uwopt.solvers.exact.floor_rectangles import edges_to, most_in_cells

BEAM = Beam("cosine-power", exponent=1.5)
TILTED = (math.sin(0.4), 0.0, math.cos(0.4)), (0.0, math.sin(0.4), math.cos(0.4)), (0.0, 0.0, 1.0)


@pytest.mark.parametrize("aim", TILTED)
@pytest.mark.parametrize("place", [(0.0, 0.0), (0.0, 0.6), (0.3, 0.0), (0.3, 0.6)])
def test_all_quadrants_count_wherever_lamps_stand_and_aim(place, aim):
    """A lamp a hair aside, or turned by one, sees no two quadrants alike."""
    along, across = edges_to(1.3), edges_to(1.0)
    hair = 1e-9

    def light(x_m: float, y_m: float, turned: float) -> np.ndarray:
        lamps = Lamps((x_m,), (y_m,), (0.1,), ((aim[0] + turned, aim[1] + turned, aim[2]),), (1.0,))
        return most_in_cells(BEAM, lamps, along, across, 2.0, 0.2)

    apart = light(place[0] + hair, place[1] + hair, hair)
    np.testing.assert_allclose(light(*place, 0.0), apart, rtol=1e-3)
    assert light(*place, 0.0).sum() == pytest.approx(apart.sum(), rel=1e-6)
