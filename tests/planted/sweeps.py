"""Planted defects of sweeps over many missions: what is lost, twice, or taken for an answer that is none."""

from __future__ import annotations

from planted.defect import Defect

TESTS = "tests/sweeps/test_sweep.py"

DEFECTS = (
    Defect(
        name="a sweep whose time is over sends more missions",
        file="uwopt/sweeps/run.py",
        old="if self.done < self.total and self.deadline.passed():",
        new="if self.done > self.total and self.deadline.passed():",
        test=f"{TESTS}::test_time_that_is_over_keeps_what_is_done",
    ),
    Defect(
        name="rows of another catalogue are believed",
        file="uwopt/sweeps/identity.py",
        old='DECIDING = ("uwopt", "program", "catalogue")',
        new='DECIDING = ("uwopt", "program")',
        test=f"{TESTS}::test_another_catalogue_or_program_is_noticed[catalogue]",
    ),
    Defect(
        name="files that files name are not looked at",
        file="uwopt/sweeps/files.py",
        old="if depth and path.suffix",
        new="if not depth and path.suffix",
        test=f"{TESTS}::test_a_changed_input_is_noticed[file of a file]",
    ),
    Defect(
        name="a confidence asked of all is no input",
        file="uwopt/sweeps/job.py",
        old="self.system_hash, self.ways.changes(), *traded])",
        new="self.system_hash, *traded])",
        test=f"{TESTS}::test_a_changed_input_is_noticed[confidence]",
    ),
    Defect(
        name="an interruption loses its batch",
        file="uwopt/sweeps/work.py",
        old="return SweepReply(rows, most_memory_mb(), cut=True)",
        new="return SweepReply([], most_memory_mb(), cut=True)",
        test=f"{TESTS}::test_an_interruption_keeps_what_is_done",
    ),
    Defect(
        name="a batch whose worker died is forgotten",
        file="uwopt/sweeps/run.py",
        old="self._suspects.append(batch)",
        new="self.done += len(batch.tasks)",
        test=f"{TESTS}::test_what_dies_twice_is_worked_out_all_the_same",
    ),
    Defect(
        name="a mission whose process ends once is given up",
        file="uwopt/sweeps/run.py",
        old="DEATHS = 3 ",
        new="DEATHS = 1 ",
        test=f"{TESTS}::test_what_dies_twice_is_worked_out_all_the_same",
    ),
    Defect(
        name="a mission whose worker died is done for ever",
        file="uwopt/sweeps/store.py",
        old='if not (message or "").startswith(DIED)',
        new="if message != DIED",
        test=f"{TESTS}::test_only_a_mission_that_ends_each_process_is_given_up",
    ),
    Defect(
        name="rows that stand twice count twice",
        file="uwopt/sweeps/store.py",
        old="last = np.append(key[1:] != key[:-1], True)[: len(key)]",
        new="last = np.append(True, key[1:] != key[:-1])[: len(key)]",
        test=f"{TESTS}::test_small_files_are_joined_and_rows_that_stand_twice_count_once",
    ),
    Defect(
        name="points of trade-offs lose the objectives they trade",
        file="uwopt/sweeps/rows.py",
        old="| {FRONT + name: value for name, value in one.values.items()}",
        new="| {FRONT + name: 0.0 for name, value in one.values.items()}",
        test=f"{TESTS}::test_each_point_of_a_trade_off_is_a_row",
    ),
    Defect(
        name="pieces of a table begin their inputs anew",
        file="uwopt/sweeps/summary.py",
        old="        passed = upto\n",
        new="",
        test=f"{TESTS}::test_a_table_is_the_same_in_pieces_of_any_size[1]",
    ),
    Defect(
        name="a damaged file ends the run",
        file="uwopt/sweeps/store.py",
        old="except (pa.ArrowException, OSError, ValueError, KeyError):",
        new="except KeyError:",
        test=f"{TESTS}::test_a_damaged_file_is_set_aside_and_its_missions_worked_out_again",
    ),
    Defect(
        name="a blank cell is a value",
        file="uwopt/sweeps/inputs.py",
        old="isinstance(given, str) and not given.strip()",
        new="isinstance(given, str) and not given",
        test=f"{TESTS}::test_a_table_sets_keys_and_leaves_empty_cells_alone",
    ),
    Defect(
        name="workers with another catalogue are welcome",
        file="uwopt/sweeps/cluster.py",
        old="        if what:\n",
        new="        if what and not worker:\n",
        test="tests/sweeps/test_cluster.py::test_workers_with_another_program_are_refused",
    ),
    Defect(
        name="workers elsewhere are sent no files",
        file="uwopt/sweeps/run.py",
        old="with_files=scheduler is not None",
        new="with_files=False",
        test="tests/sweeps/test_cluster.py::test_rows_are_those_of_one_process_though_a_worker_is_killed",
    ),
    Defect(
        name="a kit serves with any number of lamps and cameras",
        file="uwopt/sweeps/kits.py",
        old="if not (allowed and bodies and few.lights):",
        new="if not (bodies and few.lights):",
        test="tests/sweeps/test_portfolio.py::test_a_kit_serves_where_a_search_over_its_parts_finds_settings",
    ),
    Defect(
        name="the price of a portfolio is not looked at",
        file="uwopt/sweeps/portfolio.py",
        old="np.asarray(prices, dtype=float)",
        new="np.ones(len(prices))",
        test="tests/sweeps/test_portfolio.py::test_choices_are_those_that_trying_all_finds[2]",
    ),
    Defect(
        name="missions of one pattern count once",
        file="uwopt/sweeps/portfolio.py",
        old="size, -counts, np.zeros(len(prices)))",
        new="size, -np.sign(counts), np.zeros(len(prices)))",
        test="tests/sweeps/test_portfolio.py::test_choices_are_those_that_trying_all_finds[0]",
    ),
    Defect(
        name="neighbours answer where scenarios are to be counted",
        file="uwopt/sweeps/neighbours.py",
        old="if wanted.confidence != CENTRAL:",
        new="if wanted.confidence is None:",
        test=f"{TESTS}::test_neighbours_do_not_answer_where_scenarios_are_to_be_counted",
    ),
    Defect(
        name="the best by exact numbers is recommended though it cannot be set",
        file="uwopt/sweeps/neighbours.py",
        old="if best.minimised < value_as_set(winner, goal) - goal",
        new="if best.minimised < best.minimised - goal",
        test=f"{TESTS}::test_neighbours_do_not_answer_where_what_can_be_set_costs_the_best_much",
    ),
    Defect(
        name="the best as listed is not what stands in the row",
        file="uwopt/sweeps/rows.py",
        old='"objective": best.objective_value,',
        new='"objective": None if best.rounded is None else best.rounded.objective_value,',
        test=f"{TESTS}::test_each_row_is_what_solve_says",
    ),
)
