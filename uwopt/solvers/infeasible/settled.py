"""What the search that found nothing proves beside: requirements and keys of which none of its bounds knows.

Where bounds alone discarded every design, none of them was tried. A requirement that none of the rules asks about,
which discarded them, changes nothing when it is dropped: each design still falls by the same rule, and no search is
needed to know.
"""

from __future__ import annotations

from collections.abc import Iterator

from uwopt.solvers.exact.account import Account
from uwopt.solvers.infeasible.freed_rules import MAY_PASS, OF_IMAGERS

BUDGETS = ("cost", "mass_kg", "power_w", "energy_wh")  # rules in the order of bounds, and the limits of which they are
FEEDING = ("battery_wh", "camera_between_images", "lamps_between_images")  # keys that a limit of power or energy knows
#: Requirements that only a design with its settings is asked about.
OF_SETTINGS = ("max_skew_px", "max_airy_px", "min_uniformity", "peak_power_w")
#: And those that bounds ask of a design's light and lens, each under its own rule.
OF_BOUNDS = ("max_white_balance", "min_mtf_half_nyquist")


def untouched(account: Account) -> Iterator[str]:
    """Requirements and keys that alone cannot let anything through; none where a design was tried.

    account : of a search of all there is that found nothing, and without a ceiling
    """
    if account.evaluated or account.discarded.get("bound", 0):
        return

    def are_idle(*rules: str) -> bool:
        """Whether none of these rules discarded anything, whatever it may have discarded after another."""
        return not any(account.discarded.get(rule, 0) for rule in rules)

    yield from OF_SETTINGS
    yield from (name for name in OF_BOUNDS if are_idle(name))
    yield from (name for name in sorted(OF_IMAGERS) if are_idle(*MAY_PASS[name]))
    # what an earlier budget discarded it did whatever the later ones are; what two do together the later one counts
    yield from (name for place, name in enumerate(BUDGETS) if are_idle(*BUDGETS[place:]))
    if are_idle("power_w", "energy_wh"):
        yield from FEEDING
