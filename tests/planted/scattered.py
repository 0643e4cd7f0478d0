"""Planted defects of light scattered more than once: its attenuations, its tables, and the Monte Carlo behind them."""

from __future__ import annotations

from planted.defect import Defect

SPECTRA = "uwopt/forward/spectra.py"
FULL = "tests/evaluation/test_full_physics.py"
TABLES = "tests/forward/test_multiple.py"
MONTE_CARLO = "tests/test_multiple_scattering.py"
FLOOR_LOBE = "        beam = problem.floor_lobe(scene_index, lighting.optics, lighting.mount, range_m)\n"

DEFECTS = (
    Defect(
        name="K of the lamp's leg forgets how wide the lobe is",
        file="uwopt/model/multiple.py",
        old="return np.deg2rad(LAMP_DEG) + LAMP_BY_LOBE * np.asarray(half_power_angle_rad, dtype=float)",
        new="return np.deg2rad(LAMP_DEG) + 0.0 * np.asarray(half_power_angle_rad, dtype=float)",
        test="tests/model/test_multiple.py::test_wider_lobes_lose_less_of_what_is_scattered",
    ),
    Defect(
        name="the forward veil loses on its way what the lamps' light does",
        file=SPECTRA,
        old='if part == "wide" else self.near_leg_per_m()',
        new='if part == "wide" else self.lamp_leg_per_m(0)',
        test=f"{FULL}::test_mean_veils_under_smooth_lobes[all orders, dome]",
    ),
    Defect(
        name="the veil from elsewhere on the floor loses only what is absorbed",
        file=SPECTRA,
        old='return self.veil_leg_per_m(range_m) if part',
        new='return 0.98 * self.veil_leg_per_m(range_m) if part',
        test=f"{FULL}::test_mean_veils_under_smooth_lobes[all orders, dome]",
    ),
    Defect(
        name="pixels see no veil from elsewhere on the floor",
        file="uwopt/forward/lamp_light.py",
        old="veil = veil + wide_gain(along, across, **seen)",
        new="veil = veil + 0.0 * wide_gain(along, across, **seen)",
        test=f"{FULL}::test_darkest_pixel[all orders, dome]",
    ),
    Defect(
        name="a spot of the floor counts alike from wherever it is seen",
        file="uwopt/model/veil/wide.py",
        old="seen = share * flux[meets] * cosine / np.square(far_m)",
        new="seen = share * flux[meets] / np.square(far_m)",
        test=f"{FULL}::test_mean_veils_under_smooth_lobes[all orders, dome]",
    ),
    Defect(
        name="the bound of the forward veil forgets what comes from elsewhere",
        file="uwopt/forward/effects.py",
        old="most += min(float(np.max(wide / np.maximum(signal, TINY))), MOST_SHARE)",
        new="most += 0.0 * min(float(np.max(wide / np.maximum(signal, TINY))), MOST_SHARE)",
        test="tests/forward/test_effects.py::test_no_effect_changes_more_than_its_bound[(13, 9)]",
    ),
    Defect(
        name="the easiest water sends a veil from elsewhere",
        file="uwopt/solvers/confidence/panels.py",
        old="return self.near_leg_per_m()",
        new="return 0.9 * self.near_leg_per_m()",
        test="tests/solvers/test_confidence_proof.py::"
        "test_the_best_of_waters_is_no_worse_where_light_is_scattered_more_than_once[0.7]",
    ),
    Defect(
        name="daylight's path radiance loses c, as if what is scattered were lost",
        file="uwopt/forward/sun_light.py",
        old="absorption_per_m=scene.absorption_per_m(), backward",
        new="absorption_per_m=scene.attenuation_per_m, backward",
        test=f"{TABLES}::test_daylight_in_murky_water_is_that_of_all_orders",
    ),
    Defect(
        name="daylight from the floor loses what the lamps' light does",
        file="uwopt/forward/sun_light.py",
        old="all_light = scene.sun_leg_per_m() if self.multiple else",
        new="all_light = scene.attenuation_per_m if self.multiple else",
        test="tests/forward/test_oblique.py::test_daylight_from_an_oblique_floor_loses_what_its_way_takes",
    ),
    Defect(
        name="the Monte Carlo of daylight absorbs nothing",
        file="docs/validation/orders/daylight.py",
        old="weight = survivor(rng, weight * water.albedo, LEAST * first)",
        new="weight = survivor(rng, weight, LEAST * first)",
        test=f"{MONTE_CARLO}::test_rows_of_daylight_are_found_again",
    ),
    Defect(
        name="light that leaves out orders is bounded without the sun",
        file="uwopt/forward/effects.py",
        old='found["multiple_scattering"] = (bound + sun + other, saved_s)',
        new='found["multiple_scattering"] = (bound, saved_s)',
        test="tests/forward/test_effects.py::test_orders_of_daylight_are_kept_where_the_sun_shines",
    ),
    Defect(
        name="backscatter that is scattered again on its way to the camera is lost",
        file=SPECTRA,
        old="return both, both",
        new="return both, self.scene.attenuation_per_m",
        test=f"{FULL}::test_mean_veils_under_smooth_lobes[all orders, dome]",
    ),
    Defect(
        name="lamps of one spectrum share a table, whatever their lobes",
        file=SPECTRA,
        old="return (*self._weight_key(spectrum, efficiency, channel), self._lobes_rad[spectrum])",
        new="return self._weight_key(spectrum, efficiency, channel)",
        test=f"{TABLES}::test_lamps_of_unlike_lobes_have_tables_of_their_own",
    ),
    Defect(
        name="single scattering cannot be asked for",
        file="uwopt/forward/scene.py",
        old="return bool(self.scattering) and self.view.scene.multiple_scattering",
        new="return bool(self.scattering)",
        test=f"{TABLES}::test_single_scattering_is_what_the_scene_or_the_model_asks_for",
    ),
    Defect(
        name="nothing is said of water thicker than was tested",
        file="uwopt/evaluation/tested.py",
        old="thickness > TESTED_THICKNESS:",
        new="thickness > 1e9:",
        test=f"{TABLES}::test_a_result_says_that_it_leaves_the_tested_range[9C-True-True]",
    ),
    Defect(
        name="molecules scatter evenly",
        file="uwopt/model/scattering.py",
        old="(1 + cos + f * (1 + cos**3) / 3)",
        new="(1 + cos + f * (1 + cos) / 3)",
        test="tests/model/test_multiple.py::test_share_beyond_of_molecules_is_the_integral_of_their_function[30.0]",
    ),
    Defect(
        name="the Monte Carlo forgets half of the density of its places",
        file="docs/validation/orders/camera.py",
        old="return t, 0.5 * by_angle + 0.5 * c",
        new="return t, 0.5 * by_angle + 1.0 * c",
        test=f"{MONTE_CARLO}::test_walks_of_one_order_are_the_single_scattering_of_the_quadrature",
    ),
    Defect(
        name="photons in a slab turn by half the angle drawn",
        file="docs/validation/orders/walk.py",
        old="sine = np.sin(psi)\n    s, t, u = sine * np.cos(phi), sine * np.sin(phi), np.cos(psi)",
        new="psi = psi / 2\n    sine = np.sin(psi)\n    s, t, u = sine * np.cos(phi), sine * np.sin(phi), np.cos(psi)",
        test=f"{MONTE_CARLO}::test_an_isotropic_half_space_reflects_what_h_functions_say",
    ),
    Defect(
        name="detail is lost by the angle and not by the place on the floor",
        file="uwopt/model/detail.py",
        old="kernel = _kernel(2.0 * np.pi * FREQUENCIES[:, None] * angle)",
        new="kernel = _kernel(1.5 * np.pi * FREQUENCIES[:, None] * angle)",
        test=("tests/model/test_detail.py::test_wells_phase_function_has_the_transfer_of_his_closed_form[30.0]",
              f"{MONTE_CARLO}::test_walks_show_the_detail_that_the_model_says[petzold HAOCE 11]"),
    ),
    Defect(
        name="bars of the search show nothing in the veil",
        file="uwopt/forward/sharpness.py",
        old="detail = 1.0 if self.detail is None else self.detail.gain(frequency_cyc_per_px)",
        new="detail = 1.0",
        test="tests/solvers/test_cell_bounds.py"
        "::test_no_point_is_better_than_the_bound_of_a_cell_that_holds_it[signal of bars that show in the veil]",
    ),
    Defect(
        name="bounds of cells see an even veil",
        file="uwopt/solvers/settings/cell_bounds.py",
        old="still = bars.still(sinc_mtf(nu), nu) * bars.detail",
        new="still = bars.still(sinc_mtf(nu), nu)",
        test="tests/solvers/test_cell_bounds.py"
        "::test_no_point_is_better_than_the_bound_of_a_cell_that_holds_it[signal of bars that show in the veil]",
    ),
    Defect(
        name="the bound of information in a cell sees an even veil",
        file="uwopt/solvers/settings/cell_information.py",
        old="log_snr, centre_log_snr = log_snr + log_gain[:, None], centre_log_snr + log_gain",
        new="log_snr, centre_log_snr = log_snr + 0.0 * log_gain[:, None], centre_log_snr",
        test="tests/solvers/test_cell_information.py"
        "::test_no_image_has_more_than_the_tangent_at_another[near-none]",
    ),
    Defect(
        name="the bound of information and its price sees an even veil",
        file="uwopt/solvers/settings/joint.py",
        old="np.minimum(plain * np.square(gain), plain + np.log2(gain))",
        new="np.minimum(plain, plain + np.log2(gain))",
        test="tests/solvers/test_joint.py::test_the_table_holds_every_transfer_of_the_model[veil with detail]",
    ),
    Defect(
        name="CasADi's aperture sees an even veil",
        file="uwopt/solvers/continuous/aperture.py",
        old="snr = float(sharp.texture_gain[0]) * sensor.snr(",
        new="snr = 1.0 * sensor.snr(",
        test="tests/solvers/test_aperture.py::test_the_program_has_the_information_of_the_model",
    ),
    Defect(
        name="detail shows in a veil that is not counted",
        file="uwopt/forward/detail.py",
        old="return forward_veil and contraction.multiple and",
        new="return contraction.multiple and",
        test="tests/forward/test_detail.py::test_detail_is_lost_where_scattering_is_counted_once_or_not_at_all",
    ),
    Defect(
        name="a colour that is scattered little bounds detail",
        file="uwopt/forward/detail.py",
        old="float(scene.particles_per_m().max())",
        new="float(scene.particles_per_m().min())",
        test="tests/forward/test_detail.py::test_no_colour_and_no_smaller_pixel_has_more_than_bounds_say",
    ),
    Defect(
        name="a photograph lifts its mean by what varies",
        file="uwopt/report/pictures/photograph.py",
        old="np.where(frequency > 0.0, detail(frequency), 1.0)",
        new="detail(frequency)",
        test="tests/report/test_picture.py::test_a_veil_that_shows_detail_lifts_what_varies_and_not_the_mean",
    ),
    Defect(
        name="scenarios show the detail of the water as it is known",
        file="uwopt/solvers/confidence/together.py",
        old="detail=rows.sharp.detail.hazier(ratio)",
        new="detail=rows.sharp.detail",
        test="tests/solvers/test_confidence_proof.py"
        "::test_detail_in_the_veil_is_each_scenarios_own_and_no_bound_shows_less",
    ),
    Defect(
        name="the easiest water shows least detail in its veil",
        file="uwopt/solvers/confidence/panels.py",
        old="max(float(one.particles_per_m().max()) for one in self.states)",
        new="min(float(one.particles_per_m().min()) for one in self.states)",
        test="tests/solvers/test_confidence_proof.py"
        "::test_detail_in_the_veil_is_each_scenarios_own_and_no_bound_shows_less",
    ),
    Defect(
        name="bounds of light forget that water widens lobes",
        file="uwopt/solvers/exact/floor_rectangles.py",
        old=f"{FLOOR_LOBE}        if scene.slope:",
        new="        beam = problem.beam(scene_index, lighting.optics)\n        if scene.slope:",
        test="tests/solvers/test_widened_lobes.py"
        "::test_no_image_gets_more_light_than_its_bounds_where_lobes_are_widened[lobe of 20 deg-leaning out]",
    ),
    Defect(
        name="bounds of light on a tilted floor forget that water widens lobes",
        file="uwopt/solvers/exact/floor_rectangles.py",
        old=f"{FLOOR_LOBE}        lamps, port_m",
        new="        beam = problem.beam(scene_index, lighting.optics)\n        lamps, port_m",
        test="tests/solvers/test_widened_lobes.py"
        "::test_no_image_gets_more_light_than_its_bounds_where_lobes_are_widened[lobe of 20 deg-looking ahead]",
    ),
    Defect(
        name="the envelope of a widened beam is that of the lamp's own",
        file="uwopt/model/beam.py",
        old="share * falling_envelope(own(beam))[1] + halo if share else halo",
        new="share * falling_envelope(own(beam))[1] if share else halo",
        test="tests/model/test_widened.py::test_bounds_of_a_widened_lobe_lie_nowhere_below_it[2.0-0.9-narrow]",
    ),
    Defect(
        name="the water of a panel widens lobes as one of its states does",
        file="uwopt/solvers/confidence/panels.py",
        old="return bounding(each, left, most=not back)",
        new="return each[0]",
        test="tests/solvers/test_widened_lobes.py"
        "::test_the_best_of_waters_has_the_brightest_lobe_of_all_and_the_faintest_that_is_sent_back",
    ),
    Defect(
        name="a bound of lobes is one at its knots alone",
        file="uwopt/model/widened.py",
        old="about = pick(np.lib.stride_tricks.sliding_window_view(near, 17)[::8], axis=1)",
        new="about = fine[::8]",
        test="tests/model/test_widened.py::test_a_bound_of_several_waters_lobes_is_one_at_every_angle[True-narrow]",
    ),
    Defect(
        name="light that water turns back widens the lobe all the same",
        file="uwopt/model/widened.py",
        old="forward = angle < 0.5 * np.pi",
        new="forward = angle < np.pi",
        test="tests/model/test_widened.py::test_no_light_is_lost_but_what_is_absorbed_and_turned_back[3.0-narrow]",
    ),
    Defect(
        name="light arrives turned by all of its angle, wherever it was turned",
        file="uwopt/model/widened.py",
        old="apparent = np.arctan((1.0 - s) * np.tan(angle))",
        new="apparent = angle",
        test=("tests/model/test_widened.py::test_the_mean_square_angle_grows_by_a_third_of_what_is_turned[2.0]",
              f"{FULL}::test_mean_electrons_under_smooth_lobes[all orders, flat port, narrow lobes, turbid]"),
    ),
    Defect(
        name="the water sends back the lobe of the lamps",
        file="uwopt/forward/lamp_light.py",
        old="beam=self.contraction.back_lobe(self.optics))",
        new="beam=self.beam)",
        test=f"{FULL}::test_mean_veils_under_smooth_lobes[all orders, flat port, narrow lobes, turbid]",
    ),
    Defect(
        name="the lobe that is sent back is as wide near the lamp as far from it",
        file="uwopt/model/veil/ray.py",
        old="beam, view.distance_m[..., None] * cosh)",
        new="beam, 1.0)",
        test=f"{FULL}::test_mean_veils_under_smooth_lobes[all orders, flat port, narrow lobes, turbid]",
    ),
    Defect(
        name="the floor's illuminance is that of the lamps' own lobe",
        file="uwopt/forward/floor_light.py",
        old="beam = problem.floor_lobe(scene_index, optics, mount, range_m)\n    weight",
        new="beam = problem.beam(scene_index, optics)\n    weight",
        test=f"{FULL}::test_floor_illuminance_over_the_traced_footprint[all orders, flat port, narrow lobes, turbid]",
    ),
    Defect(
        name="what light of all orders changes is judged by the mean alone",
        file="uwopt/forward/effects.py",
        old="changed += most_apart(*there) * margin(many)",
        new="changed += 0.0",
        test="tests/forward/test_multiple.py::test_what_orders_change_is_bounded_at_the_corners_too",
    ),
    Defect(
        name="nothing is said of lobes narrower than were tested",
        file="uwopt/evaluation/tested.py",
        old="not narrow <= lobe_deg <= wide",
        new="not lobe_deg <= wide",
        test=f"{TABLES}::test_a_result_says_that_lobes_are_beyond_those_tested[6-3C-True]",
    ),
    Defect(
        name="light that goes round to the floor bears no longer way",
        file="uwopt/model/widened.py",
        old="detour = s + (1.0 - s) / np.cos(angle) - 1.0 / np.cos(apparent)",
        new="detour = 0.0 * angle",
        test=f"{FULL}::test_mean_electrons_under_smooth_lobes[all orders, flat port, narrow lobes, turbid]",
    ),
    Defect(
        name="nothing that turned back falls on the floor again",
        file="uwopt/model/widened.py",
        old="(np.atleast_1d(returned)[:, None] - 1.0)",
        new="0.0",
        test=f"{FULL}::test_mean_electrons_under_smooth_lobes[all orders, flat port, narrow lobes, turbid]",
    ),
    Defect(
        name="what the water sends back is widened on its way from the lamp alone",
        file="uwopt/model/widened.py",
        old="carried = 2.0 * carried - carried[:, :1]",
        new="carried = 1.0 * carried",
        test=f"{FULL}::test_mean_veils_under_smooth_lobes[all orders, flat port, narrow lobes, turbid]",
    ),
    Defect(
        name="the veil from elsewhere bears no longer way",
        file="uwopt/forward/scene.py",
        old="self.absorption_per_m() * way_m",
        new="self.absorption_per_m() * 0.0",
        test=f"{TABLES}::test_attenuations_lie_between_absorption_and_c_and_grow_with_what_is_lost",
    ),
)
