"""Planted defects of all lightings bounded at once, and of what that settles."""

from __future__ import annotations

from planted.defect import Defect

ANY, SETTLED = "uwopt/solvers/exact/any_lighting.py", "uwopt/solvers/infeasible/freed_rules.py"
TESTS, AT_HAND = "tests/solvers/test_any_lighting.py", "tests/solvers/test_hardware_at_hand.py"
DARK = f"{TESTS}::test_only_what_is_dark_under_each_lighting_is_left_dark[level]"
ONLY = f"{TESTS}::test_only_what_discarded_nothing_is_settled"

DEFECTS = (
    Defect(
        name="of places of lamps the darkest stands for all",
        file=ANY,
        old="one, light=np.maximum(one.light, other.light)",
        new="one, light=np.minimum(one.light, other.light)",
        test=DARK,
    ),
    Defect(
        name="the least able lamp stands for all",
        file=ANY,
        old="np.where(np.isnan(effective), np.inf, effective).max())",
        new="np.where(np.isnan(effective), np.inf, effective).min())",
        test=DARK,
    ),
    Defect(
        name="flashes may be too slow for all lightings at once",
        file=ANY,
        old="                enough &= need.rate_hz <= ablest.max_rate_hz * COARSE_ROUND\n",
        new="",
        test=f"{TESTS}::test_flashes_that_take_longer_to_load_than_images_are_apart_light_nothing",
    ),
    Defect(
        name="all lightings at once discard nothing",
        file=ANY,
        old="            dark &= ~enough\n",
        new="            dark &= False\n",
        test=DARK,
    ),
    Defect(
        name="what no lighting lights is not counted",
        file="uwopt/solvers/exact/search.py",
        old='        self.account.charge("light", int(self.bounds.sizes.sum() * dark.sum()))\n',
        new="",
        test=f"{TESTS}::test_every_combination_is_counted_as_it_is_one_lighting_after_another[45.0-one by one]",
    ),
    Defect(
        name="rows of pairs that no lighting lights are not counted",
        file="uwopt/solvers/exact/large.py",
        old='            account.charge("light", int(size[index[dark]].sum()) * self.designs)\n',
        new="",
        test=f"{TESTS}::test_every_combination_is_counted_as_it_is_one_lighting_after_another[45.0-by pairs]",
    ),
    Defect(
        name="a limit of power is said not to help where it discarded designs",
        file=SETTLED,
        old="if are_idle(*BUDGETS[place:]))",
        new="if True)",
        test=f"{ONLY}[0-discarded1-settled1-open_yet1]",
    ),
    Defect(
        name="what was tried in vain is settled by bounds",
        file=SETTLED,
        old="    if account.evaluated or ",
        new="    if ",
        test=f"{ONLY}[1-discarded5-settled5-open_yet5]",
    ),
    Defect(
        name="a search of another mission settles what does not help",
        file="uwopt/solvers/infeasible/relaxer.py",
        old=" or like.problem.mission != self.mission:",
        new=":",
        test=f"{TESTS}::test_a_search_of_another_mission_settles_nothing",
    ),
    Defect(
        name="a key is told though the hardware at hand does not fit",
        file="uwopt/solvers/infeasible/moves.py",
        old="        if found is None or not found.outcome.best:\n            return False\n        self.helpful",
        new="        if found is None:\n            return False\n        self.helpful",
        test=f"{AT_HAND}::test_a_key_that_the_nearest_hardware_needs_moved_is_told_without_a_search",
    ),
    Defect(
        name="a requirement helps though the hardware at hand does not fit",
        file="uwopt/solvers/infeasible/singles.py",
        old="            found = same_hardware(known, relaxed)\n            if found.outcome.best:\n",
        new="            found = same_hardware(known, relaxed)\n            if found:\n",
        test=f"{AT_HAND}::test_a_requirement_without_which_known_hardware_fits_helps",
    ),
    Defect(
        name="a longer mission is told to suit what does not last it",
        file="uwopt/solvers/infeasible/least_change.py",
        old="-math.inf if lasts_less(found, mission) else math.inf",
        new="math.inf",
        test=f"{AT_HAND}::test_a_mission_is_drawn_in_to_what_its_parts_last",
    ),
    Defect(
        name="the hardware at hand is asked of nothing else",
        file="uwopt/solvers/infeasible/why_nothing.py",
        old="    try_hardware(singles, mover)\n",
        new="",
        test=f"{AT_HAND}::test_what_hardware_does_is_told_where_no_search_of_a_moved_key_ends",
    ),
    Defect(
        name="of a large catalogue no few are tried",
        file="uwopt/solvers/infeasible/relaxer.py",
        old="    most = FEW_PAIRS * number",
        new="    return None\n    most = FEW_PAIRS * number",
        test=f"{AT_HAND}::test_of_a_catalogue_too_large_to_list_a_few_pairs_are_tried_first",
    ),
)
