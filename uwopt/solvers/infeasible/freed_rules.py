"""Which rules imagers may pass once a requirement is dropped or a key moved, and which then stand in the way.

Of a search that found nothing: what likely stood in the way, and what none of its bounds knows. Where bounds alone
discarded every design, none was tried: a requirement that none of the rules asks about which discarded them changes
nothing when it is dropped, for each design still falls by the same rule.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator
from dataclasses import replace

from uwopt.solvers.exact.account import RULES, Account, Outcome
from uwopt.solvers.exact.node_bounds import NODE_RULES
from uwopt.solvers.recommend import Sought

OTHER_WATER = "other water"  # of which no rule of an imager knows
OTHER_LAMPS = "other lamps"  # where they stand, how they lean and how many there are: the same
NO_REASONS = frozenset({"better_housing", "bound", "mount", "image_circle", "complete"})  # whatever is asked
ENERGY = "energy_wh"
BUDGETS = ("cost", "mass_kg", "power_w", ENERGY)  # rules in the order of bounds, and the limits of which they are
LATE_RULES = frozenset({*NODE_RULES, *BUDGETS}) - NO_REASONS  # that know of lamps
HOURS, OF_HOURS = "duration_h", ("run time", "rated time")  # rules of parts that a shorter mission may have again
SETTINGS = "settings"  # that none of a design's does: a reason, though no rule of a search
MOST_REASONS = 2  # told
SWITCHES = ("camera_between_images", "lamps_between_images")  # that may be off, which limits of power or energy know
LAMPS_AT, LAMPS_LEAN, LAMPS = OF_LAMPS = ("light_baseline_m", "light_tilt_deg", "light_count")
BATTERY = "battery_wh"  # that cost and mass know, too
OF_LARGER = frozenset(BUDGETS[:2])  # what a larger one that the system brings along takes more of

#: Requirements that no imager's rule or column knows.
LIT = (
    "min_snr", "max_white_balance", "max_skew_px", "max_airy_px", "max_gain_db", "mean_level", "min_contrast",
    "min_uniformity", "min_mtf_half_nyquist", "peak_power_w",
)  # fmt: skip
OF_LIGHT = frozenset({*LIT, OTHER_WATER, OTHER_LAMPS})
#: Those that count of imagers alone: who fits without them and not with them breaks their rule.
OF_IMAGERS = frozenset({"max_gsd_mm", "min_swath_m", "min_common_swath_m", "max_depth_error_mm", "data_rate_mb_s"})
STORED = frozenset({"storage_gb", "card_gb"})
OF_RATE = STORED | {"frame_rate", "data_rate_mb_s"}
#: Rules of imagers that may pass what they fail once a requirement is dropped or weakened. Of requirements that are
#: not named here anything may change, parts and their prices included.
MAY_PASS: dict[str, frozenset[str]] = {
    **dict.fromkeys((*LIT, *BUDGETS), frozenset[str]()),
    **{name: frozenset({name}) for name in sorted(OF_IMAGERS)},
    "resolve_mm": frozenset({"max_gsd_mm"}),
    "min_dof_m": frozenset({"focus", "min_dof_m", "lens_stop_down"}),
    "max_blur_px": frozenset({"max_blur_px"}),
    "lens_stop_down": frozenset({"lens_stop_down", "min_dof_m"}),
    "overlap": OF_RATE | {"max_blur_px", "min_swath_m"},
}
#: The same of keys that are no requirements, where what they ask is less.
MOVES_PASS: dict[str, frozenset[str]] = {
    "speed_m_s": OF_RATE | {"max_blur_px"},
    "frame_interval_s": OF_RATE,
    HOURS: STORED,
    OTHER_WATER: frozenset(),
    OTHER_LAMPS: frozenset(),
}
FREES = MAY_PASS | MOVES_PASS


def in_the_way(found: Sought, freed: str = "") -> tuple[str, ...]:
    """The rules by which the designs of a search fall that found none, but for that which is `freed`.

    Those that know of lamps if any, else `SETTINGS` of what was solved in vain, else the last of an imager's.
    """
    account = found.outcome.account
    lost = account.discarded
    rules = [rule for rule in RULES if lost.get(rule, 0) > 0 and rule not in NO_REASONS and rule != freed]
    late = [rule for rule in rules if rule in LATE_RULES] or ([SETTINGS] if account.evaluated else rules[-1:])
    return tuple(sorted(late, key=lambda rule: -lost.get(rule, 0))[:MOST_REASONS])


# ---------------------------------------------------------------- settled by bounds


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
        yield from SWITCHES
        if are_idle("cost", "mass_kg"):
            yield BATTERY


# ---------------------------------------------------------------- likely in the way


MOST_OF_ONE, MOST_SUSPECTS = 2, 3  # of one search, and of all: what more rules speak of is asked in its turn
ASKED_BY = {"light": "min_snr", SETTINGS: "min_snr"}  # what a rule of another name holds


def of_lamps(outcome: Outcome) -> Account:
    """The account of a search but for what its imagers lost by themselves: a camera beyond the budget is no last fall.

    Of a large catalogue, of which no list of imagers is left, and where none was left to lamps, all of it.
    """
    account, tally = outcome.account, outcome.imagers.tally.discarded
    imagers = len(outcome.imagers) + sum(tally.values())
    if account.total == 0 or not tally or account.total % imagers:
        return account
    each, lost = account.total // imagers, account.discarded
    own = {rule: lost[rule] - each * tally.get(rule, 0) for rule in LATE_RULES if rule in lost}
    return replace(account, discarded={**lost, **own}) if any(own.values()) else account


def suspects_of(account: Account, names: Collection[str]) -> list[str]:
    """Of these requirements those that are likeliest in the way, the likeliest first.

    What passes all else falls last: by rules that know of lamps, the one that discards most first; else what no rule
    discards has no settings, mostly for want of light; else by the last rules of imagers.
    """
    lost = [rule for rule in RULES if account.discarded.get(rule, 0) > 0]
    late = sorted((rule for rule in lost if rule in LATE_RULES), key=lambda rule: -account.discarded[rule])
    first = [*late, *([SETTINGS] if account.evaluated else []), *([] if late or account.evaluated else lost[::-1])]
    return asked_by(first, names)[:MOST_OF_ONE]


def asked_by(rules: Iterable[str], names: Collection[str]) -> list[str]:
    """The requirements that these rules hold, of those with such names."""
    return [name for name in dict.fromkeys(ASKED_BY.get(rule, rule) for rule in rules) if name in names]
