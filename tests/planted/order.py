"""Defects in what a buyer works with: workbooks, cards, comparisons, tenders."""

from planted.defect import Defect

LIMITS = "tests/evaluation/test_setting_limits.py"
WORSE = "tests/solvers/test_worse_water.py"
SPEC = "tests/solvers/test_specification.py"
OFFERS = "tests/catalog/test_offers.py"
BOOKS = "tests/documents/test_workbooks.py"
TENDER = "tests/report/order/test_tender.py"
COMPARE = "tests/report/compare/test_compare.py"
CARD = "tests/report/card/test_card.py"
BOOK = "tests/report/order/test_bom_book.py"

DEFECTS = (
    Defect(
        name="nobody asks for a voltage that is not known",
        file="uwopt/report/text/not_counted.py",
        old='if row.kind in FED or row.id == "host-computer"}',
        new="if supply_volts(row.id)}",
        test=f"{BOOK}::test_voltages_are_those_of_the_maker_s_sheet_and_all_others_are_to_be_asked",
    ),
    Defect(
        name="a computer needs no place",
        file="uwopt/report/text/not_counted.py",
        old="if row.id in apart]:",
        new='if row.id == "none"]:',
        test=f"{BOOK}::test_a_computer_needs_a_place_that_nobody_counted",
    ),
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
        old="formats.margin_ends(margin)[0], margin.satisfied)",
        new="formats.margin_ends(margin)[0], margin.value is not None)",
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
    Defect(
        name="the worse end of the last step is a limit",
        file="uwopt/solvers/explain/specification.py",
        old="made[which][n] = worse(asked[n], float(step))",
        new="made[which][n] = worse(asked[n], 1.02 * float(step))",
        test=f"{SPEC}::test_every_limit_holds_within_and_not_beyond",
    ),
    Defect(
        name="a rival that is as good does not count",
        file="uwopt/solvers/explain/specification.py",
        old="value <= rival - FINER * abs(rival)",
        new="value <= rival",
        test=f"{SPEC}::test_a_rival_that_is_as_good_ends_the_claim",
    ),
    Defect(
        name="all limits at once are taken for enough",
        file="uwopt/solvers/explain/specification.py",
        old="        return at(low)",
        new="        return at(1.0)",
        test=f"{SPEC}::test_all_numbers_together_still_do_and_lie_within_their_limits",
    ),
    Defect(
        name="units of answers are dropped",
        file="uwopt/catalog/offers.py",
        old='return f"{value:.10g}", ""',
        new='return found[1], ""',
        test=f"{OFFERS}::test_numbers_with_units_are_read_in_the_column_s",
    ),
    Defect(
        name="quotes that no longer hold count",
        file="uwopt/catalog/offers.py",
        old="elif until and until < today:",
        new="elif False:",
        test=f"{OFFERS}::test_a_price_counts_with_currency_day_and_while_it_holds",
    ),
    Defect(
        name="an own part takes the named one's numbers",
        file="uwopt/catalog/offers.py",
        old='and COLUMNS[kind][name].form != "number"',
        new="and True",
        test=f"{OFFERS}::test_a_part_of_its_own_takes_words_but_no_numbers_from_the_named_one",
    ),
    Defect(
        name="formulas of a workbook are taken as text",
        file="uwopt/documents/workbooks.py",
        old='if getattr(cell, "data_type", "") == "f":',
        new="if False:",
        test=f"{BOOKS}::test_formulas_are_refused_with_their_place",
    ),
    Defect(
        name="a workbook may unpack to any size",
        file="uwopt/documents/workbooks.py",
        old="if sum(piece.file_size for piece in pieces) > MOST_UNPACKED",
        new="if sum(piece.file_size for piece in pieces) < 0",
        test=f"{BOOKS}::test_what_grows_too_large_is_refused_unread",
    ),
    Defect(
        name="the dearer of two offers counts",
        file="uwopt/api/quoting.py",
        old="ranks[place] < ranks[found[key]]",
        new="ranks[place] > ranks[found[key]]",
        test=f"{TENDER}::test_of_two_offers_of_one_part_the_cheaper_counts",
    ),
    Defect(
        name="what is offered is not searched",
        file="uwopt/api/quoting.py",
        old="catalog[key] = named[key] = [*catalog[key], offer.part_id]",
        new="named[key] = catalog[key]",
        test=f"{TENDER}::test_what_is_offered_is_searched_beside_what_the_mission_names",
    ),
    Defect(
        name="limits are rounded to the unsafe side",
        file="uwopt/report/order/tender_lines.py",
        old="outward = math.ceil if limit.more_is_better else math.floor",
        new="outward = math.floor if limit.more_is_better else math.ceil",
        test=f"{TENDER}::test_limits_are_rounded_to_the_safe_side",
    ),
    Defect(
        name="what keeps the vehicle from going nearer is not told",
        file="uwopt/solvers/explain/worse_water.py",
        old='            obstacle = furthest_rule(outcome.account.discarded) or ""',
        new='            obstacle = ""',
        test=f"{WORSE}::test_what_stops_the_vehicle_on_its_way_down_is_told",
    ),
    Defect(
        name="a new part of a class has no purpose",
        file="uwopt/catalog/offers.py",
        old='meant = {"purpose": str(made_for)} if made_for else {}',
        new="meant: dict[str, str] = {}",
        test=f"{OFFERS}::test_a_class_to_be_made_becomes_the_maker_s_part_even_where_he_says_it_is_the_named_one",
    ),
    Defect(
        name="of a number with two ends one is sought",
        file="uwopt/solvers/explain/specification.py",
        old="signs = (1, -1) if field.name in BOTH_ENDS",
        new="signs = (1,) if field.name in BOTH_ENDS",
        test="tests/solvers/test_specification.py::test_a_focal_length_has_two_ends",
    ),
    Defect(
        name="numbers with two ends are tried at one of them together",
        file="uwopt/solvers/explain/specification.py",
        old="for choice in product(*ends.values())]",
        new="for choice in zip(*ends.values())]",
        test="tests/solvers/test_specification.py::test_every_end_is_tried_with_every_other",
    ),
    Defect(
        name="ballast is not asked for",
        file="uwopt/api/risks.py",
        old="weight_kg < -BUOYANT_KG",
        new="weight_kg < -1e9",
        test="tests/api/test_risks.py::test_housings_that_float_are_told_with_their_ballast",
    ),
)
