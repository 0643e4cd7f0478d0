"""Planted defects of updates of the catalogue and of the list of what is old."""

from __future__ import annotations

from planted.defect import Defect

TESTS = "tests/catalog/test_update.py::"
UPDATE = "uwopt/catalog/update.py"
CHANGES = "uwopt/catalog/changes.py"

DEFECTS = (
    Defect(
        name="a wrong cell is told by the log instead of the file that was brought",
        file=UPDATE,
        old="Row(brought[key].file, brought[key].line, row.cells)",
        new="row",
        test=f"{TESTS}test_a_row_that_cannot_stand_is_refused_with_its_reason",
    ),
    Defect(
        name="a row is changed without a source",
        file=UPDATE,
        old="if not said_by or said_by == CLEARED:",
        new="if said_by == CLEARED:",
        test=f"{TESTS}test_a_row_that_cannot_stand_is_refused_with_its_reason",
    ),
    Defect(
        name="prices without a date are taken",
        file=UPDATE,
        old="if not DATE.fullmatch(dated):",
        new="if dated and not DATE.fullmatch(dated):",
        test=f"{TESTS}test_a_row_that_cannot_stand_is_refused_with_its_reason",
    ),
    Defect(
        name="the ends of an old price stay with the new one",
        file=UPDATE,
        old='("price_low", "price_high", "price_status", "price_date"), "")',
        new='("price_status", "price_date"), "")',
        test=f"{TESTS}test_a_quote_takes_the_place_of_an_estimate_and_its_ends",
    ),
    Defect(
        name="a price that is cleared leaves its date",
        file=UPDATE,
        old='("price_low", "price_high", "price_status", "price_date"), "")',
        new='("price_low", "price_high", "price_status"), "")',
        test=f"{TESTS}test_a_cleared_price_takes_its_ends_its_date_and_its_status_along",
    ),
    Defect(
        name="a formula of a spreadsheet stands in the log",
        file=UPDATE,
        old='    faults += _formula_faults(row, {"id": part_id, **told, "source": said_by})\n',
        new="",
        test=f"{TESTS}test_a_row_that_cannot_stand_is_refused_with_its_reason",
    ),
    Defect(
        name="lines of a note that begin like a comment are lost from the log",
        file=UPDATE,
        old='BREAKS.sub(" ", text)',
        new="text",
        test=f"{TESTS}test_a_note_of_several_lines_is_one_line_of_the_log",
    ),
    Defect(
        name="a new source throws the old ones away",
        file=UPDATE,
        old='" | ".join(text for text in (old, new) if text)',
        new="new",
        test=f"{TESTS}test_a_quote_changes_its_cells_and_the_log_says_from_what_to_what_and_by_whom",
    ),
    Defect(
        name="an id may stand twice in what is brought",
        file=UPDATE,
        old="            seen[key] = row\n",
        new="",
        test=f"{TESTS}test_a_row_that_cannot_stand_is_refused_with_its_reason",
    ),
    Defect(
        name="changed parts are not built before they are kept",
        file=UPDATE,
        old="    faults += _faults_after(before, changes, log, seen)\n",
        new="",
        test=f"{TESTS}test_a_row_that_cannot_stand_is_refused_with_its_reason",
    ),
    Defect(
        name="a second update forgets the first",
        file=UPDATE,
        old="return (*self.before, *self.changes)",
        new="return self.changes",
        test=f"{TESTS}test_a_new_part_is_added_and_later_changed_and_cleared",
    ),
    Defect(
        name="a dry run writes",
        file="uwopt/cli/catalog.py",
        old="if plan.changes and not dry_run:",
        new="if plan.changes:",
        test=f"{TESTS}test_a_dry_run_writes_nothing_and_a_folder_is_taken_whole",
    ),
    Defect(
        name="changed parts go to the end of the catalogue",
        file="uwopt/catalog/load.py",
        old="return (*(by_key.pop(plain_name(part.id), part) for part in parts), *by_key.values())",
        new="return (*(p for p in parts if plain_name(p.id) not in by_key), *by_key.values())",
        test=f"{TESTS}test_the_log_is_a_file_of_parts_that_leaves_all_other_facts",
    ),
    Defect(
        name="a filled gap does not free its part",
        file="uwopt/catalog/load.py",
        old="kept = tuple(e for e in catalog.exclusions if plain_name(e.part_id) not in keys)",
        new="kept = catalog.exclusions",
        test=f"{TESTS}test_a_filled_gap_frees_a_part_for_the_search",
    ),
    Defect(
        name="of two logs the last one counts",
        file="uwopt/catalog/load.py",
        old="                changes += log\n",
        new="                changes = log\n",
        test=f"{TESTS}test_two_logs_are_read_one_after_the_other",
    ),
    Defect(
        name="the list of what is old forgets parts that no order holds",
        file="uwopt/catalog/stale.py",
        old="whole = whole or not uses",
        new="whole = not uses",
        test="tests/catalog/test_stale.py::test_the_whole_catalogue_is_listed_with_what_orders_rest_on_before_the_rest",
    ),
    Defect(
        name="nobody tells that the catalogue moved on",
        file=CHANGES,
        old="!= change.old\n",
        new="== change.old\n",
        test=f"{TESTS}test_the_check_of_a_log_tells_what_has_moved_on_beneath_it",
    ),
)
