"""Planted defects of tables over varied keys: what a list proves, where systems change, which keys ask for more."""

from __future__ import annotations

from planted.defect import Defect

SWEEP = "uwopt/solvers/explain/sweep.py"
TESTS = "tests/api/test_whatif.py"

DEFECTS = (
    Defect(
        name="a list is believed beyond its ceiling",
        file=SWEEP,
        old="if best and best[0].minimised <= one.ceiling and few.outcome.complete:",
        new="if best and few.outcome.complete:",
        test=f"{TESTS}::test_lists_hide_no_winner[1-speed_m_s-0.3,0.6,1.05,1.3,2.5]",
    ),
    Defect(
        name="a list serves weaker points",
        file=SWEEP,
        old="a == b or (sign and sign * (b - a) > 0)",
        new="a == b or (sign and sign * (b - a) != 0)",
        test=f"{TESTS}::test_a_list_serves_no_weaker_point",
    ),
    Defect(
        name="a full list claims its whole ceiling",
        file=SWEEP,
        old="ceiling, self.share = last, max(0.5 * self.share, LEAST_SHARE)",
        new="self.share = max(0.5 * self.share, LEAST_SHARE)",
        test=f"{TESTS}::test_a_full_list_claims_no_more_than_its_last",
    ),
    Defect(
        name="more speed is always stricter",
        file="uwopt/mission/varying.py",
        old='if self.name == "speed_m_s" and by_area:',
        new='if self.name == "speed_m_s" and by_area and False:',
        test=f"{TESTS}::test_speed_is_not_stricter_where_area_is_asked_for",
    ),
    Defect(
        name="a least budget is the first to be solved",
        file="uwopt/mission/varying.py",
        old="return 1 if self.name in STRICTER_UP else -1 if self.name in STRICTER_DOWN else 0",
        new="return 1 if self.name in STRICTER_UP | STRICTER_DOWN else 0",
        test=f"{TESTS}::test_lists_hide_no_winner[1-cost-9000,7600,7210,5000]",
    ),
    Defect(
        name="switches are no sharper than the points",
        file="uwopt/api/varied.py",
        old="low, high = self._bisected(k, a, b, sharp)",
        new="low, high = a, b",
        test=f"{TESTS}::test_systems_change_where_the_table_says",
    ),
    Defect(
        name="a spider's line varies nothing",
        file="uwopt/mission/varying.py",
        old="place[varied.name] = rounded(float(place[varied.name]) * factor)",
        new="place[varied.name] = rounded(float(place[varied.name]) * 1.0)",
        test=f"{TESTS}::test_spider_moves_one_quantity_at_a_time",
    ),
    Defect(
        name="an interruption loses the table",
        file="uwopt/api/whatif.py",
        old="if not (grid.points or lines):",
        new="if not lines:",
        test=f"{TESTS}::test_interruption_keeps_what_is_solved",
    ),
)
