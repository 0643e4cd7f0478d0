"""Defects of flashes that fade: how much light a shutter lets in, what it blurs, what dark current does with it."""

from planted.defect import Defect

FLASH = "uwopt/model/flash.py"
TIMES = "uwopt/forward/flash_times.py"
OF_CELLS = "tests/solvers/test_cells.py::test_a_flash_that_fades_is_cut_where_its_light_pays"
CUT = (
    "tests/evaluation/test_full_physics.py::"
    "test_a_flash_gives_its_lumen_seconds_or_what_comes_while_the_shutter_is_open"
)

DEFECTS = (
    Defect(
        name="a flash fades to a tenth whatever its data sheet says",
        file=FLASH,
        old="return np.asarray(duration_s) / np.abs(np.log(at_frac))",
        new="return np.asarray(duration_s) / np.abs(np.log(0.1 + 0.0 * at_frac))",
        test="tests/model/test_flash.py::test_half_of_the_light_is_out_after_t05_and_nine_tenths_after_t01",
    ),
    Defect(
        name="a flash is over at the end of its stated duration",
        file=FLASH,
        old="np.where(decays, decay_s(duration_s, at_frac=share) * -np.log(LEFT_AT_THE_END), duration_s)",
        new="np.where(decays, duration_s, duration_s)",
        test="tests/model/test_flash.py::test_a_flash_is_over_with_a_hundredth_left",
    ),
    Defect(
        name="a flash blurs as long as it shines",
        file=FLASH,
        old="lambda t, tau: tau * np.sqrt(-12.0 * np.expm1(-2.0 * _log_sinhc(0.5 * t / tau)))",
        new="lambda t, tau: t",
        test="tests/model/test_flash.py::test_the_blur_is_that_of_steady_light_of_the_same_variance",
    ),
    Defect(
        name="a cut flash gives light in proportion to its time",
        file="uwopt/forward/figures.py",
        old="at_peak_s = rows.lights.flash.light_s(collected_s)",
        new="at_peak_s = collected_s * rows.lights.flash.full_s / rows.lights.flash.whole_s",
        test=f"{CUT}[2000.0-0.5-1.0-{700.0 * (1.0 - 0.5**0.5) / 0.99}]",
    ),
    Defect(
        name="a flash in a system file stays as bright as it begins",
        file="uwopt/catalog/readers/read_light.py",
        old='if kind == "flash" and made["flash_duration_at_frac"] is None:',
        new="if False:",
        test=f"{CUT}[2000.0-None-0.6-{700.0 * (1.0 - 0.07**0.3) / 0.99}]",
    ),
    Defect(
        name="the search takes a flash's time at its peak for its open shutter",
        file="uwopt/forward/scene_rows.py",
        old="        lit_s = self.flash.open_s(time_s)\n",
        new="        lit_s = time_s\n",
        test="tests/solvers/test_dark.py::test_a_flash_that_fades_is_cut_where_dark_electrons_outrun_its_light",
    ),
    Defect(
        name="dark electrons are thought to grow no faster than a fading flash's light",
        file="uwopt/solvers/settings/dark.py",
        old="    return np.asarray(fades & ~rows.is_whole_flash(rows.time_min_s) & (rows.dark_current_e_s > 0.0))",
        new="    return np.asarray(fades & (rows.dark_current_e_s < 0.0))",
        test="tests/solvers/test_dark.py::test_a_flash_that_fades_is_cut_where_dark_electrons_outrun_its_light",
    ),
    Defect(
        name="cells take a flash's light for its blur",
        file="uwopt/solvers/settings/cell_bounds.py",
        old="        return self.flash.take(d).blur_s(time_s) if self.flash.fade else time_s",
        new="        return time_s",
        test=f"{OF_CELLS}[information-more2]",
    ),
    Defect(
        name="cells let a flash go on only as long as steady light may blur",
        file="uwopt/solvers/settings/cell_bounds.py",
        old="within = flash.light_s(some_s) if self.sunlit else flash.within_blur_s(some_s)",
        new="within = flash.light_s(some_s)",
        test=f"{OF_CELLS}[snr_db-more1]",
    ),
    Defect(
        name="under the sun a cut flash is open for its time at its peak",
        file="uwopt/solvers/settings/cell_points.py",
        old="np.where(free, np.maximum(wanted, least), scene.opened_s(d, time))",
        new="np.where(free, np.maximum(wanted, least), time)",
        test=f"{OF_CELLS}[snr_db-more3]",
    ),
    Defect(
        name="bounds let in no more of a flash than its light in proportion to time",
        file=TIMES,
        old="return np.minimum(1.0, self.within_blur_s(longest_s) / self.full_s)",
        new="return np.minimum(1.0, longest_s / self.whole_s)",
        test="tests/forward/test_flash_times.py::test_no_more_of_a_flash_comes_than_its_bound_says",
    ),
    Defect(
        name="a flash may blur no longer than it shines",
        file=TIMES,
        old="return self.light_s(np.asarray(flash.open_time_of_blur_s(blur_s, decay_s=self.decay_s)))",
        new="return self.light_s(blur_s)",
        test="tests/forward/test_flash_times.py::test_the_light_within_a_blur_is_all_that_blurs_no_more",
    ),
    Defect(
        name="CasADi's exposure of a cut flash is its time at its peak",
        file="uwopt/solvers/continuous/pieces.py",
        old="        return flash.open_time_s(time_s, decay_s=self.flash_decay_s) + self.exposure_shift_s\n",
        new="        return time_s + self.exposure_shift_s\n",
        test="tests/solvers/test_continuous.py::test_a_flash_that_fades_agrees_with_the_search[casadi]",
    ),
)
