"""Users' own parts, prices and curves: every fault told once, with file, row, id, column and a way out."""

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from uwopt.catalog.checkfile import TEMPLATE_KINDS, file_report, template
from uwopt.catalog.load import read_catalog
from uwopt.catalog.userparts import _listed_numbers, yaml_table
from uwopt.errors import CatalogError
from uwopt.report.text.parts import check_blocks

LENS_HEADER = "id,manufacturer,focal_length_mm,f_number_min,f_number_max,optical_format_in,mounts,price\n"


def written(folder, name, text, encoding="utf-8"):
    path = folder / name
    path.write_text(text, encoding=encoding)
    return path


def faults_of(path):
    with pytest.raises(CatalogError) as caught:
        read_catalog([path])
    return caught.value.faults


def test_own_lens_joins_the_catalogue_with_estimates_for_the_rest(tmp_path):
    written(tmp_path, "lenses.csv", LENS_HEADER + "my-lens,Me,6,2,8,2/3,C,99\n")
    lens = read_catalog(["lenses.csv"], base_dir=tmp_path).part("my-lens")
    assert (lens.focal_length_mm, lens.price.value, lens.price.status) == (6.0, 99.0, "user")
    assert lens.transmission_frac.estimated
    assert lens.image_circle_mm == 11.0


def test_every_fault_of_a_file_is_told_once(tmp_path):
    path = written(
        tmp_path,
        "lenses.csv",
        LENS_HEADER
        + "a,Me,8 mm,2,8,2/3,C,99\n"
        + "b,Me,-6,2,8,2/3,C,99\n"
        + "c,Me,6,8,2,2/3,C,nan\n"
        + "c,Me,6,2,8,2/3,Z,99\n"
        + ',Me,"6,5",2,8,2/3,C,99\n',
    )
    faults = faults_of(path)
    for words in (
        "lenses.csv row 2 (a): focal_length_mm = '8 mm' is not a number; the unit belongs in the header",
        "lenses.csv row 3 (b): focal_length_mm = -6 must be a number above 0",
        "lenses.csv row 4 (c): price = 'nan' is not a finite number",
        "lenses.csv row 4 (c): f_number_min = 8 is above f_number_max = 2",
        "lenses.csv row 5 (c): id stands already in row 4",
        "lenses.csv row 5 (c): mounts = 'Z' is not any of C, CS",
        "lenses.csv row 6: id is empty",
        "lenses.csv row 6: focal_length_mm = '6,5' has a comma; write a decimal point: 6.5",
    ):
        assert sum(words in fault for fault in faults) == 1, words


def test_unknown_column_suggests_the_near_one(tmp_path):
    path = written(tmp_path, "lenses.csv", "id,focal_lenght_mm,focal_length_mm\na,8,8\n")
    assert "column 'focal_lenght_mm' is unknown; did you mean 'focal_length_mm'?" in faults_of(path)[0]


def test_semicolons_are_named(tmp_path):
    path = written(tmp_path, "lenses.csv", "id;focal_length_mm\na;8\n")
    assert "separated by ';'" in faults_of(path)[0]


def test_unquoted_decimal_comma_shows_as_a_cell_too_many(tmp_path):
    path = written(tmp_path, "lenses.csv", "id,focal_length_mm\na,8,5\n")
    assert "has 3 cells, the header has 2" in faults_of(path)[0]


def test_byte_order_mark_and_empty_lines_do_no_harm(tmp_path):
    path = written(tmp_path, "l.csv", "id,focal_length_mm\n\na,8\n,\n", "utf-8-sig")
    assert read_catalog([path]).part("a").focal_length_mm == 8.0


def test_other_encoding_is_named(tmp_path):
    path = written(tmp_path, "l.csv", "id,focal_length_mm,note\na,8,Öl\n", "latin-1")
    assert "not UTF-8" in faults_of(path)[0]


def test_missing_file_is_named(tmp_path):
    assert "no such file" in faults_of(tmp_path / "none.csv")[0]
    assert file_report(tmp_path / "none.csv").faults == (f"{tmp_path / 'none.csv'}: no such file; check its name.",)


def test_id_of_the_built_in_catalogue_is_taken(tmp_path):
    path = written(tmp_path, "lenses.csv", "id,focal_length_mm\nKowa_LM8FC24M,8\n")
    assert "already that of a part of the built-in catalogue" in faults_of(path)[0]


def test_faults_of_all_files_come_together(tmp_path):
    first = written(tmp_path, "lenses.csv", "id,focal_length_mm\na,x\n")
    prices = written(tmp_path, "prices.csv", "id,price\nno-such-part,10\n")
    with pytest.raises(CatalogError) as caught:
        read_catalog([first], prices=prices)
    assert len(caught.value.faults) == 2


def test_yaml_parts_of_several_kinds(tmp_path):
    path = written(
        tmp_path,
        "mine.yaml",
        "- part: lens\n  id: y-lens\n  focal_length_mm: 12\n  mounts: [C, CS]\n"
        "- part: light\n  id: y-lamp\n  kind: continuous\n  flux_lm: 1000\n  dim_levels: [1, 0.5]\n"
        "- part: port\n  id: y-dome\n  geometry: dome\n  outer_radius_mm: 75\n  depth_rating_m: ~\n",
    )
    catalog = read_catalog([path])
    assert catalog.part("y-lens").mounts == ("C", "CS")
    assert catalog.part("y-lamp").dim_levels == (1.0, 0.5)
    assert catalog.part("y-dome").depth_rating_m is None


@pytest.mark.parametrize(
    "row",
    [
        "a,lens,8,,1|nan|2", "a,lens,8,,0.5|inf", "a,lens,8,,0|1", "a,lens,8,,1|200", "a,lens,8,,long",
        "a,light,,1|nan|0.5,", "a,light,,0.5|0.25,", "a,light,,1|0,",
    ],
)  # fmt: skip
def test_lists_of_numbers_hold_numbers_within_their_range(tmp_path, row):
    header = "id,part,focal_length_mm,dim_levels,spacers_mm\n"
    faults = " ".join(faults_of(written(tmp_path, "mine.csv", f"{header}{row}\n")))
    assert ("spacers_mm" if "lens" in row else "dim_levels") + " = " in faults


@pytest.mark.parametrize("text", ["1|nan|0.5", "0.5|inf", "0.5|-inf", "0.5|one", ""])
def test_a_list_with_what_is_no_number_holds_none(text):
    """Told here: where NaN lies among the sorted is by chance, so a range finds it at times alone."""
    assert _listed_numbers(text) == []


def test_yaml_faults_carry_their_line(tmp_path):
    path = written(
        tmp_path, "mine.yaml", "- part: lens\n  id: a\n  focal_length_mm: 12\n- part: lens\n  id: b\n"
    )
    assert "mine.yaml row 4 (b): focal_length_mm is empty; a lens needs it." in faults_of(path)


def test_broken_yaml_is_told_with_its_line(tmp_path):
    (fault,) = faults_of(written(tmp_path, "mine.yaml", "- part: lens\n  id: [a\n"))
    assert fault.startswith("mine.yaml line 3 column 1: is not valid YAML")


def test_cells_of_yaml_are_the_text_as_written(tmp_path):
    text = (
        "parts:\n- &first {part: lens, id: 010, model: '~', price: 1.50, note: null}\n- {<<: *first, id: b}\n"
    )
    first, second = yaml_table(text, "mine.yaml").rows
    assert first.cells == {"part": "lens", "id": "010", "model": "~", "price": "1.50", "note": ""}
    assert second.cells == {**first.cells, "id": "b"} and (first.line, second.line) == (2, 3)


def test_all_faults_of_yaml_parts_are_told_at_once(tmp_path):
    text = "- part: lens\n  part: lens\n  id: *nowhere\n- just text\n"
    faults = "\n".join(yaml_table(text, "mine.yaml").faults)
    assert "mine.yaml line 2: [0].part stands twice (also in line 1); remove one." in faults
    assert "mine.yaml line 3: alias *nowhere refers to nothing before it" in faults
    assert "mine.yaml row 4: is not a part; write keys and values." in faults


def test_csv_of_several_kinds_needs_a_part_column(tmp_path):
    path = written(tmp_path, "mine.csv", "part,id,focal_length_mm,geometry\nlens,a,8,\nport,b,,flat\n")
    catalog = read_catalog([path])
    assert catalog.part("a", "lens").id == "a" and catalog.part("b", "port").id == "b"
    assert "Add a column part" in faults_of(written(tmp_path, "what.csv", "id,model\na,b\n"))[0]


def test_prices_override_and_change_the_currency(tmp_path):
    prices = written(
        tmp_path, "prices.csv", "id,price,currency,date\nflir_bfs_u3_51s5m,1000,EUR,2026-11-01\n"
    )
    camera = read_catalog(prices=prices).part("flir-bfs-u3-51s5m")
    assert (camera.price.value, camera.price.status, camera.currency) == (1000.0, "user", "EUR")


def test_price_of_an_unknown_part_names_near_ids(tmp_path):
    prices = written(tmp_path, "prices.csv", "id,price\nflir-bfs-u3-51s5,10\n")
    with pytest.raises(CatalogError, match=r"prices.csv row 2 .*did you mean .*flir-bfs-u3-51s5m"):
        read_catalog(prices=prices)


def test_own_spectrum_and_beam_profile_of_a_lamp(tmp_path):
    written(tmp_path, "blue.csv", "wavelength_nm,relative_power\n400,0\n450,1\n500,0\n700,0\n")
    written(tmp_path, "beam.csv", "angle_deg,intensity\n0,1\n40,0.5\n90,0\n")
    path = written(
        tmp_path, "lights.csv",
        "id,kind,flux_lm,spectrum,beam_profile\nmy-lamp,continuous,1000,blue.csv,beam.csv\n",
    )  # fmt: skip
    lamp = read_catalog([path]).part("my-lamp")
    assert lamp.spectrum.x == (400.0, 450.0, 500.0, 700.0)
    assert (lamp.beam, lamp.beam_profile.y) == ("tabulated", (1.0, 0.5, 0.0))


def test_ies_file_gives_an_absolute_profile(tmp_path):
    ies = "IESNA:LM-63-2002\nTILT=NONE\n1 1000 1 3 1 1 2 0 0 0\n1 1 50\n0 45 90\n0\n300 150 0\n"
    written(tmp_path, "lamp.ies", ies)
    header = "id,kind,flux_lm,beam_profile\n"
    catalog = read_catalog([written(tmp_path, "lights.csv", header + "my-lamp,continuous,1000,lamp.ies\n")])
    lamp = catalog.part("my-lamp")
    assert (lamp.beam_profile.y, lamp.beam_profile_is_candela) == ((300.0, 150.0, 0.0), True)


def test_guide_number_of_a_beam_stated_in_water_counts_the_narrowing(tmp_path):
    # GN 10: 215 cd s in air; a 90 deg lobe in water has 3 / (2 pi) cd/lm, in air 1.34**2 less:
    # 215 * 1.34**2 / 0.47746 / 35 lm s/J = 23.10 J
    header = "id,kind,guide_number_m,beam_angle_deg,beam_medium\n"
    path = written(tmp_path, "lights.csv", header + "my-flash,flash,10,90,water\n")
    assert read_catalog([path]).part("my-flash").flash_energy_j.value == pytest.approx(23.10, abs=0.01)


def test_lens_of_an_unknown_format_is_kept_out_with_its_name(tmp_path):
    path = written(tmp_path, "lenses.csv", "id,focal_length_mm,mounts,optical_format_in\nodd,8,C,3/7\n")
    assert "'3/7' is not known" in read_catalog([path]).exclusions_of("odd")[0].reason


def test_a_bad_price_list_is_told_row_by_row_with_every_fault(tmp_path):
    text = 'id,price,currency,date\nkowa-nosuch,12,EUR,2026-01-01\nflir-bfs-u3-51s5m,"1304,50",dollar,14.08.2026\n'
    report = file_report(written(tmp_path, "quotes.csv", text))
    assert (report.n_rows, len(report.faults)) == (2, 4)  # `1 row: 3 faults`, of which each row told one
    (block,) = check_blocks(report)
    told = " ".join(map(str, block.lines))
    words = ("kowa-nosuch", "price", "three letters", "YYYY-MM-DD")
    assert [*map(told.index, words)] == sorted(map(told.index, words))  # in the order of the file
    assert file_report(written(tmp_path, "more.csv", "id,price,date\nflir-bfs-u3-51s5m,1300,2026-08\n")).ok


@pytest.mark.parametrize(
    ("currency", "fault"),
    [("UDS", "write USD"), ("EUT", "write EUR"), ("ERU", "write EUR"), ("QQQ", "ISO 4217"), ("sek", ""), ("USD", "")],
)
def test_a_misspelt_currency_is_told_in_its_row(tmp_path, currency, fault):
    text = f"id,price,currency,date\nflir-bfs-u3-51s5m,1300,{currency},2026-08-01\n"
    path = written(tmp_path, "quotes.csv", text)
    report = file_report(path)
    assert report.ok == (not fault) and len(report.notes) == (currency == "sek")  # limits.rates may have that
    if fault:
        assert "row 2" in report.faults[0] and fault in report.faults[0]
        with pytest.raises(CatalogError, match="row 2"):  # of which `solve` told neither file nor row
            read_catalog([], path)


def test_a_column_without_its_unit_is_told_with_it(tmp_path):
    text = "part,id,resolution_x,resolution_y,pixel_pitch\ncamera,a,4000,3000,1.5\n"
    told = file_report(written(tmp_path, "cameras.csv", text)).faults[:3]
    assert all(map(str.__contains__, told, ("'resolution_x_px'", "'resolution_y_px'", "'pixel_pitch_um'")))


def test_a_quote_for_a_part_that_no_file_has_is_a_fault(tmp_path):
    own = written(tmp_path, "lenses.csv", "part,id,focal_length_mm,mounts\nlens,my-lens,8,C\n")
    quotes = written(tmp_path, "quotes.csv", "id,price\nmy-lens,210\n")
    assert not file_report(quotes).ok and file_report(quotes, [own]).ok


def test_columns_that_a_spreadsheet_parts_by_semicolons_are_one_fault(tmp_path):
    (fault,) = file_report(written(tmp_path, "lenses.csv", "id;focal_length_mm;mounts\na;8;C\n")).faults
    assert "separated by ';'" in fault


def test_spectrum_with_a_gap_in_the_visible_names_it(tmp_path):
    report = file_report(written(tmp_path, "s.csv", "wavelength_nm,relative_power\n450,1\n650,1\n"))
    assert any("400-450 nm" in fault for fault in report.faults)
    assert any("650-700 nm" in fault for fault in report.faults)


def test_wavelengths_that_do_not_increase_are_told_with_their_row(tmp_path):
    text = "# mine\nwavelength_nm,reflectance\n400,0.1\n500,0.2\n500,0.2\n700,1.2\n"
    report = file_report(written(tmp_path, "s.csv", text))
    assert any("row 5: wavelength_nm = 500 does not increase" in fault for fault in report.faults)
    assert any(
        "reflectance = 1.2 must be a number at least 0 and at most 1" in fault for fault in report.faults
    )


def test_quantum_efficiency_of_a_colour_camera_needs_all_channels(tmp_path):
    written(
        tmp_path, "qe.csv", "channel,wavelength_nm,qe\n" + "".join(f"red,{nm},0.3\n" for nm in (400, 700))
    )
    header = "id,colour,resolution_x_px,resolution_y_px,pixel_pitch_um,qe_curve\n"
    path = written(tmp_path, "cameras.csv", header + "my-cam,colour,1000,800,3.45,qe.csv\n")
    assert "lacks the channel green, blue" in faults_of(path)[0]


@pytest.mark.parametrize("kind", TEMPLATE_KINDS)
def test_every_template_is_a_file_that_checks(kind, tmp_path):
    report = file_report(written(tmp_path, f"{kind}.csv", template(kind)))
    assert report.ok, report.faults
    assert report.n_rows >= 1


def test_unknown_template_names_the_known():
    with pytest.raises(CatalogError, match="light-spectrum"):
        template("lamp")


def test_check_tells_what_will_be_estimated_or_left_out(tmp_path):
    report = file_report(written(tmp_path, "ports.csv", "id,geometry\nmy-dome,dome\n"))
    assert report.ok
    assert any("radius of curvature unknown" in note for note in report.notes)
    assert any("estimated by class: price" in note for note in report.notes)


@pytest.mark.parametrize("text", ["", "\n", "id\n", "# only a comment\n"])
def test_empty_files_are_faults_not_crashes(text, tmp_path):
    assert not file_report(written(tmp_path, "lenses.csv", text)).ok


@settings(deadline=None, max_examples=60, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(content=st.binary(max_size=200), suffix=st.sampled_from([".csv", ".yaml"]))
def test_no_file_makes_the_check_crash(content, suffix, tmp_path):
    path = tmp_path / f"lenses{suffix}"
    path.write_bytes(content)
    file_report(path)


@settings(deadline=None, max_examples=60, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    text=st.text(alphabet="- :[]{}&*!|>'\"%@`\n#,;idpartlens0123.", max_size=80),
    suffix=st.sampled_from([".csv", ".yaml"]),
)
def test_no_text_makes_the_check_crash(text, suffix, tmp_path):
    file_report(written(tmp_path, f"lenses{suffix}", text))


@pytest.mark.parametrize(
    ("columns", "cells", "pitch_um"),
    [
        ("rated_pixel_pitch_um,mounts", "2.4,C", (2.4, 1.2, 3.84)),  # machine vision: 1, 0.5 to 1.6 of the rating
        ("rated_lp_per_mm,mounts", "100,C", (5.0, 2.5, 8.0)),  # half a line pair is 5 um
        ("rated_pixel_pitch_um,mounts", "2.0,S", (3.0, 2.0, 5.0)),  # board lenses: 1.5, 1 to 2.5
        ("rated_pixel_pitch_um,mounts", "4.0,F", (3.0, 1.6, 5.0)),  # photographic: 0.75, 0.4 to 1.25
        ("mounts", "C", (2.8, 1.5, 4.7)),  # not rated
        ("rated_pixel_pitch_um,mounts,aberration_pitch_um", "2.4,C,0", (0.0, 0.0, 0.0)),  # stated: perfect
    ],
)
def test_aberrations_of_a_lens_follow_its_class_and_rating_unless_stated(columns, cells, pitch_um, tmp_path):
    written(tmp_path, "lenses.csv", f"id,focal_length_mm,{columns}\nmine,6,{cells}\n")
    found = read_catalog(["lenses.csv"], base_dir=tmp_path).part("mine").aberration_pitch_um
    assert (found.value, found.low, found.high) == pytest.approx(pitch_um)
    assert found.estimated == ("aberration" not in columns)
