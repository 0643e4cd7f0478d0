"""Defects in what a buyer works with: workbooks, cards, comparisons, tenders."""

from planted.defect import Defect

LIMITS = "tests/evaluation/test_setting_limits.py"
WORSE = "tests/solvers/test_worse_water.py"
COMPARE = "tests/report/compare/test_compare.py"
CARD = "tests/report/card/test_card.py"
BOOK = "tests/report/order/test_bom_book.py"

DEFECTS = (
    Defect(
        name="control sign before a formula",
        file="uwopt/report/order/book.py",
        old="    return defused(kept)[:MOST_CHARS]",
        new="    return defused(value)[:MOST_CHARS].replace('\\x07', '')",
        test=f"{BOOK}::test_no_text_of_a_file_becomes_a_formula",
    ),
    Defect(
        name="owned pieces are paid in every system",
        file="uwopt/report/order/bom_book.py",
        old='f"=MAX(0,F{n}*{SYSTEMS}-G{n})"',
        new='f"=(F{n}-G{n})*{SYSTEMS}"',
        test=f"{BOOK}::test_totals_follow_systems_quotes_tax_and_what_is_filled_in",
    ),
    Defect(
        name="a quote does not take the price's place",
        file="uwopt/report/order/bom_book.py",
        old="""f'=IF(L{n}<>"",H{n}*L{n},IF""",
        new="""f'=IF(L{n}="",0,0)+IF(1=0,0,IF""",
        test=f"{BOOK}::test_totals_follow_systems_quotes_tax_and_what_is_filled_in",
    ),
    Defect(
        name="high ends are summed for low ones",
        file="uwopt/report/order/bom_book.py",
        old='((16, "I"), (17, "J"), (18, "K"))',
        new='((16, "I"), (17, "K"), (18, "J"))',
        test=f"{BOOK}::test_totals_are_the_result_s_and_no_cell_is_an_error",
    ),
    Defect(
        name="the far side of the last step is told",
        file="uwopt/evaluation/setting_limits.py",
        old="SettingEnd(float(2.0 ** (sign * power)), name)",
        new="SettingEnd(float(2.0 ** (sign * (power + 1e-3))), name)",
        test=f"{LIMITS}::test_evaluate_agrees_just_within_and_just_beyond",
    ),
    Defect(
        name="brightness hides what breaks behind it",
        file="uwopt/evaluation/setting_limits.py",
        old="fails = ~held[name] & ~(left & (name == LEVEL))",
        new="fails = ~held[name]",
        test=f"{LIMITS}::test_ends_are_those_computed_by_hand",
    ),
    Defect(
        name="requirements missed as set end every range",
        file="uwopt/evaluation/setting_limits.py",
        old="if held.all() and name not in NO_RULE",
        new="if name not in NO_RULE",
        test=f"{LIMITS}::test_what_is_missed_already_does_not_count",
    ),
    Defect(
        name="focus is moved on the lens's scale, not in water",
        file="uwopt/evaluation/setting_limits.py",
        old="lens_dioptre_per_m(own_m * 2.0 ** (sign * power), focus_map=focus_map)",
        new="self.settings.dioptre_per_m[0] * 2.0 ** (sign * power)",
        test=f"{LIMITS}::test_focus_breaks_where_evaluate_says",
    ),
    Defect(
        name="better visibility counts as worse",
        file="uwopt/solvers/explain/worse_water.py",
        old="else reading / WORSE[step]",
        new="else reading * WORSE[step]",
        test=f"{WORSE}::test_worse_is_more_attenuation_or_the_next_type",
    ),
    Defect(
        name="the vehicle goes lower before settings are tried",
        file="uwopt/solvers/explain/worse_water.py",
        old="LOWER = tuple(1.0 - 0.1 * step for step in range(8))",
        new="LOWER = tuple(0.9 - 0.1 * step for step in range(7))",
        test=f"{WORSE}::test_the_altitude_is_lowered_only_where_settings_alone_do_not_help",
    ),
    Defect(
        name="a scene keeps its altitude while the vehicle goes lower",
        file="uwopt/solvers/explain/worse_water.py",
        old='scenes.append({**scene, "vehicle": lower} if own else scene)',
        new="scenes.append(scene)",
        test=f"{WORSE}::test_altitudes_of_scenes_are_lowered_with_the_vehicle_s",
    ),
    Defect(
        name="ends of settings are rounded to the nearest",
        file="uwopt/report/card/blocks.py",
        old="float(digits.quantize(step, rounding=rounding))",
        new="float(digits.quantize(step))",
        test=f"{CARD}::test_ends_are_rounded_to_the_safe_side",
    ),
    Defect(
        name="data of an hour in megabytes of a second",
        file="uwopt/report/card/blocks.py",
        old='row("data_rate_mb_s", "GB", 3.6)',
        new='row("data_rate_mb_s", "GB", 60.0)',
        test=f"{CARD}::test_the_day_s_work_is_that_of_an_hour",
    ),
    Defect(
        name="a missed requirement counts as met",
        file="uwopt/report/compare/rows.py",
        old="words.margin_ends(margin)[0], margin.satisfied)",
        new="words.margin_ends(margin)[0], margin.value is not None)",
        test=f"{COMPARE}::test_each_requirement_is_told_of_every_system",
    ),
    Defect(
        name="the best of several ratings is told",
        file="uwopt/report/compare/rows.py",
        old="if known is None or in_hand(margin) < in_hand(known):",
        new="if known is None or in_hand(margin) > in_hand(known):",
        test=f"{COMPARE}::test_of_several_parts_the_one_with_the_least_in_hand_is_told",
    ),
    Defect(
        name="a rig that misses what is asked beats the recommendation",
        file="uwopt/report/compare/rows.py",
        old='*(["it does not do what is asked"] if missed else [])',
        new="*[]",
        test=f"{COMPARE}::test_rig_that_is_better_by_the_goal_is_told_why",
    ),
)
