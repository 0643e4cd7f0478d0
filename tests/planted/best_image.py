"""Planted defects of the best image for its price."""

from __future__ import annotations

from planted.defect import Defect

PRICES = "tests/objectives/test_best_image.py"
KNEE = "tests/solvers/test_best_image.py"
CELLS = "tests/solvers/test_cells.py"

DEFECTS = (
    Defect(
        name="100 USD have the price of one unit of money",
        file="uwopt/objectives/goal.py",
        old="* usd / 100.0)",
        new="* usd)",
        test=f"{PRICES}::test_a_watt_and_100_usd_each_take_one_percent",
    ),
    Defect(
        name="prices stay in dollars whatever the currency",
        file="uwopt/objectives/goal.py",
        old="usd = to_currency(1.0, limits.currency,",
        new="usd = to_currency(1.0, 'USD',",
        test=f"{PRICES}::test_prices_hold_in_the_currency_of_the_mission",
    ),
    Defect(
        name="decibels count as e-folds",
        file="uwopt/objectives/objective.py",
        old="math.log(10.0) / 20.0 if",
        new="1.0 if",
        test=f"{PRICES}::test_signal_to_noise_counts_as_a_ratio",
    ),
    Defect(
        name="no information is taken off the constant of a best image",
        file="uwopt/objectives/objective.py",
        old="information=1.0 if self.by_ratio else 0.0",
        new="information=0.0",
        test=f"{PRICES}::test_what_no_setting_changes_is_the_price_alone",
    ),
    Defect(
        name="nobody is told that signal to noise is taken instead",
        file="uwopt/objectives/goal.py",
        old='wanted.best_image.of != "auto" or not reasons',
        new='wanted.best_image.of == "auto" or not reasons',
        test=f"{PRICES}::test_signal_to_noise_is_taken_and_told_where_information_cannot_be_asked",
    ),
    Defect(
        name="a share of the best image is one of its logarithm",
        file="uwopt/objectives/objective.py",
        old="return math.log1p(share) if self.quality else share * abs(minimised)",
        new="return share * abs(minimised)",
        test=f"{PRICES}::test_steps_are_shares_of_the_value",
    ),
    Defect(
        name="the tangent of the logarithm lies below it",
        file="uwopt/solvers/settings/cell_tangent.py",
        old="np.log(at) + value / at - 1.0",
        new="np.log(at) + value / at - 1.2",
        test=f"{CELLS}::test_best_image_where_light_is_dear",
    ),
    Defect(
        name="information of the best image counts as it is",
        file="uwopt/solvers/settings/cell_pool.py",
        old='self.objective.counted("information", information)',
        new="information",
        test=f"{CELLS}::test_best_image_where_light_is_dear",
    ),
    Defect(
        name="a veil takes more of the pixel than it has in the bound of a best image",
        file="uwopt/solvers/exact/bounds.py",
        old="np.minimum(electrons_e, contrast * most_held_e(cameras, self.problem.scenes[scene_index]))",
        new="np.minimum(electrons_e, contrast**2 * most_held_e(cameras, self.problem.scenes[scene_index]))",
        test="tests/solvers/test_bounds.py::test_a_unit_is_bounded_by_its_best[best signal under a veil]",
    ),
    Defect(
        name="what more would buy is sought within what there is",
        file="uwopt/solvers/explain/knee.py",
        old="more[what] += amount",
        new="more[what] += 0.0 * amount",
        test=f"{KNEE}::test_what_more_buys_is_the_best_within_it[cheap]",
    ),
    Defect(
        name="a limit that holds the image back is no risk",
        file="uwopt/api/risks/of_order.py",
        old="if item.beyond_limit and item.gain > asked:",
        new="if item.beyond_limit and item.gain > 100.0 * asked:",
        test="tests/report/test_knee.py::test_a_limit_below_the_knee_is_a_risk",
    ),
)
