"""Write docs/validation/multiple_scattering.csv and daylight.csv: light of all orders, by the Monte Carlo in
docs/validation/orders.

    PYTHONPATH=. python docs/make_multiple_scattering.py [lamps | daylight]

About a quarter of an hour of one processor each with numba (extra `docs`); without it this would take days.
"""

from __future__ import annotations

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

from validation.orders import cases, daylight, walk

STRIDE = 7


def main() -> None:
    """All cases at all places, thin and thick water mixed: a table that was broken off is a fair sample."""
    if not walk.COMPILED:
        sys.exit("this needs numba: pip install 'uwopt[docs]'")
    asked = sys.argv[1:] or ["lamps", "daylight"]
    if "daylight" in asked:
        daylight.write()
    if "lamps" not in asked:
        return
    drawn = cases.drawn_cases()
    mixed = [case for first in range(STRIDE) for case in drawn[first::STRIDE]]
    cases.write(cases.computed(case, place) for case in mixed for place in cases.PLACES)


if __name__ == "__main__":
    main()
