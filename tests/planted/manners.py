"""Planted defects of manners: time limits, files, terminals."""

from __future__ import annotations

from planted.defect import Defect

DEADLINE = "tests/test_deadline.py"
SEARCH_DEADLINE = "tests/solvers/test_search_deadline.py"

DEFECTS: tuple[Defect, ...] = (
    Defect(
        name="a report draws all pictures, whatever the time",
        file="uwopt/report/page/page.py",
        old='"deadline": deadline,',
        new='"deadline": NEVER,',
        test="tests/report/test_page.py::test_a_page_without_time_for_pictures_says_so_and_keeps_the_rest",
    ),
    Defect(
        name="a word that is no choice is told with the name of an exception",
        file="uwopt/cli/app.py",
        old="said.removeprefix(PREFIX)",
        new="said",
        test="tests/cli/test_manners.py::test_a_word_that_is_no_choice_is_told_without_the_name_of_an_exception",
    ),
    Defect(
        name="who solves waits for the records of fronts to load",
        file="uwopt/report/text/words.py",
        old="if TYPE_CHECKING:",
        new="if True:",
        test="tests/test_structure.py::test_import_loads_nothing_heavy[uwopt.report.text.short]",
    ),
    Defect(
        name="threads that multiply matrices wait for each other, whatever was asked for",
        file="uwopt/cli/app.py",
        old='os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")',
        new='os.environ["OPENBLAS_NUM_THREADS"] = "1"',
        test="tests/cli/test_app.py::test_products_of_matrices_share_no_threads_unless_asked_to",
    ),
    Defect(
        name="who evaluates a given system waits for the search to load",
        file="uwopt/api/accuracy.py",
        old="if TYPE_CHECKING:",
        new="if True:",
        test="tests/test_structure.py::test_import_loads_nothing_heavy[uwopt.api.evaluating]",
    ),
    Defect(
        name="who solves waits for what a system file may hold to load",
        file="uwopt/forward/assembly.py",
        old="if TYPE_CHECKING:",
        new="if True:",
        test="tests/test_structure.py::test_import_loads_nothing_heavy[uwopt.api.solving]",
    ),
    Defect(
        name="types of records are made of texts at every start",
        file="uwopt/results/basis.py",
        old='of all."""\n\n',
        new='of all."""\n\nfrom __future__ import annotations\n\n',
        test="tests/test_structure.py::test_the_types_of_checked_records_are_no_texts",
    ),
    Defect(
        name="kept values of a reference outlive their tables",
        file="tests/kept_values.py",
        old="for file in (computed_by, *tables):",
        new="for file in (computed_by,):",
        test="tests/test_kept_values.py::test_a_value_is_kept_until_code_or_table_changes[table.csv]",
    ),
    Defect(
        name="evaluation has no end of time",
        file="uwopt/api/evaluating.py",
        old="start, deadline = time.perf_counter(), Deadline.after(seconds)",
        new="start, deadline = time.perf_counter(), Deadline()",
        test=f"{DEADLINE}::test_evaluation_leaves_out_what_time_does_not_reach",
    ),
    Defect(
        name="what requirements cost is given the whole time once more",
        file="uwopt/api/solving.py",
        old="result = priced(result, central, goal, timing, deadline, progress, since_s)",
        new="result = priced(result, central, goal, timing, Deadline(), progress, since_s)",
        test=f"{DEADLINE}::test_what_requirements_cost_has_the_time_that_the_search_leaves",
    ),
    Defect(
        name="imagers whose nodes there was no time to bound are not counted",
        file="uwopt/solvers/exact/search.py",
        old="before there were bounds\n                    self.account.charge(NOT_REACHED, every",
        new="before there were bounds\n                    self.account.charge(NOT_REACHED, 0",
        test=f"{SEARCH_DEADLINE}::test_wherever_time_ends_bound_and_account_hold",
    ),
    Defect(
        name="a catalogue that there was no time to list counts as searched",
        file="uwopt/solvers/exact/search.py",
        old="return False, float(self._camera_floor()",
        new="return True, float(self._camera_floor()",
        test=f"{SEARCH_DEADLINE}::test_wherever_time_ends_bound_and_account_hold",
    ),
    Defect(
        name="a front whose time ends among veils fails",
        file="uwopt/solvers/front/search.py",
        old="        except OutOfTimeError:\n            return False",
        new="        except ZeroDivisionError:\n            return False",
        test="tests/solvers/test_search_deadline.py::test_wherever_time_ends_a_front_is_valid",
    ),
    Defect(
        name="ten thousand with a comma becomes ten",
        file="uwopt/documents/faults.py",
        old="    if _THOUSANDS.fullmatch(plain):",
        new="    if False:",
        test="tests/mission/test_mission.py::test_a_bad_mission_is_told_in_words",
    ),
    Defect(
        name="runs side by side mix their files",
        file="uwopt/report/write.py",
        old="            fcntl.flock(descriptor, fcntl.LOCK_EX)",
        new="            pass",
        test="tests/cli/test_manners.py::test_files_of_runs_side_by_side_belong_together",
    ),
    Defect(
        name="a message that cannot be written changes the status",
        file="uwopt/cli/status.py",
        old="        except OSError:  # a full disk",
        new="        except ValueError:  # a full disk",
        test="tests/cli/test_manners.py::test_status_stays_when_the_message_cannot_be_written",
    ),
    Defect(
        name="long texts may be repeated by aliases without end",
        file="uwopt/catalog/userparts.py",
        old="        if n_signs > MOST_BYTES:",
        new="        if False:",
        test="tests/cli/test_manners.py::test_aliases_that_repeat_a_long_text_are_refused",
    ),
    Defect(
        name="links to nothing pass as folders",
        file="uwopt/report/write.py",
        old="        if path.is_symlink() and not path.exists():",
        new="        if False:",
        test="tests/cli/test_manners.py::test_a_link_to_nothing_is_no_folder_for_results",
    ),
    Defect(
        name="progress in a log comes once and never again",
        file="uwopt/report/text/console.py",
        old="            self._wait(LINE_EVERY_S, self._line)\n\n",
        new="\n",
        test="tests/report/test_console.py::test_a_log_gets_a_line_each_time_the_timer_rings",
    ),
    Defect(
        name="a batch that time cuts short stays counted",
        file="uwopt/solvers/exact/search.py",
        old="self.account.restore(before)\n            self._waiting = waited",
        new="self._waiting = waited",
        test=f"{SEARCH_DEADLINE}::test_wherever_time_ends_bound_and_account_hold",
    ),
    Defect(
        name="explanations know no time limit",
        file="uwopt/api/solving.py",
        old="        trials = Trials(mission, catalog, goal, generic, patience, progress, used)",
        new="        trials = Trials(mission, catalog, goal, generic, progress=progress, like=used)",
        test=f"{DEADLINE}::test_time_that_ends_with_the_search_leaves_infeasibility_unexplained",
    ),
    Defect(
        name="what there was no time for is not told",
        file="uwopt/deadline.py",
        old="            self.left_out.append(what)\n",
        new="",
        test=f"{DEADLINE}::test_what_has_no_time_is_left_out_and_told",
    ),
    Defect(
        name="each solver of a front has all the time",
        file="uwopt/api/trading.py",
        old="max(searching_s, 0.0) / n_waiting if self.limited",
        new="max(searching_s, 0.0) if self.limited",
        test=f"{DEADLINE}::test_solvers_of_a_front_share_the_time",
    ),
    Defect(
        name="a system without lamps has lamps in its view",
        file="uwopt/evaluation/outside.py",
        old="*(() if model.unlit else other_places(mission, hardware)),",
        new="*other_places(mission, hardware),",
        test="tests/api/test_without_lamps.py::test_no_lamp_is_warned_of_in_the_system_that_solve_writes",
    ),
)
