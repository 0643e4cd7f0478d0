"""Records made of inline parts, their curves read from files or from the tables that ship."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Literal

from uwopt.catalog.inline import (
    F_NUMBERS,
    REFRACTIVE_INDEX,
    THICKNESS_MM,
    TRANSMISSION,
    InlinePart,
    flat_curve,
)
from uwopt.catalog.inline import user_number as number
from uwopt.catalog.records import Camera, Curve, Lens, Light, Port
from uwopt.catalog.tables import built_in_rows
from uwopt.errors import CatalogError
from uwopt.faults import nearest

LampKind = Literal["continuous", "pulsed_led", "flash"]


def camera(part: Any, base_dir: Path | None) -> Camera:
    """The record of an inline camera."""
    curve_id, curves = _efficiency(part.quantum_efficiency, part.colour, base_dir)
    return Camera(
        **_identity(part, "camera"),
        chip=part.chip or "",
        colour=part.colour,
        resolution_x_px=part.resolution_x_px,
        resolution_y_px=part.resolution_y_px,
        pixel_pitch_um=part.pixel_pitch_um,
        shutter=part.shutter,
        mounts=part.mounts,
        interface=part.interface or "",
        bandwidth_mb_s=number(part.bandwidth_mb_s),
        max_frame_rate_hz=number(part.max_frame_rate_hz),
        bit_depth=part.bit_depth,
        bit_depth_status="user",
        read_noise_e=number(part.read_noise_e),
        saturation_e=number(part.saturation_e),
        dark_current_e_s=number(part.dark_current_e_s),
        gain_dn_per_e=part.gain_dn_per_e,
        gain_bits=(part.gain_bits or part.bit_depth) if part.gain_dn_per_e is not None else part.gain_bits,
        max_gain_db=number(part.max_gain_db),
        black_level_dn=part.black_level_dn,
        min_exposure_us=number(part.min_exposure_us),
        max_exposure_us=number(part.max_exposure_us),
        exposure_offset_us=number(part.exposure_offset_us),
        prnu_frac=number(part.prnu_frac),
        power_w=number(part.power_w),
        qe_curves=curves,
        qe_curve_id=curve_id,
        qe_scale=number(1.0),
    )


def lens(part: Any) -> Lens:
    """The record of an inline lens."""
    return Lens(
        **_identity(part, "lens"),
        focal_length_mm=part.focal_length_mm,
        f_number_min=number(part.f_number_min),
        f_number_max=number(part.f_number_max or max(F_NUMBERS[1], part.f_number_min)),
        aperture_control=part.aperture_control,
        image_circle_mm=part.image_circle_mm,
        image_circle_status="user",
        mounts=part.mounts,
        transmission_frac=number(part.transmission_frac) or TRANSMISSION,
        rated_pixel_pitch_um=part.rated_pixel_pitch_um,
        rated_lp_per_mm=part.rated_lp_per_mm,
        min_object_distance_m=number(part.min_object_distance_m),
        distortion_pct=part.distortion_pct,
        length_mm=part.length_mm,
        diameter_mm=part.diameter_mm,
    )


def port(part: Any) -> Port:
    """The record of an inline port."""
    index = number(part.refractive_index) or (None if part.glass else REFRACTIVE_INDEX)
    return Port(
        **_identity(part, "port"),
        geometry=part.geometry,
        material=part.material or "",
        refractive_index=index,
        glass=part.glass or "",
        outer_radius_mm=part.outer_radius_mm,
        thickness_mm=number(part.thickness_mm) or THICKNESS_MM,
        clear_diameter_mm=part.clear_diameter_mm,
        gap_mm=part.gap_mm,
        depth_rating_m=part.depth_rating_m,
    )


def light(part: Any, base_dir: Path | None) -> Light:
    """The record of an inline light; a half-angle in water becomes the full angle there."""
    kind: LampKind = part.kind or ("flash" if part.flash_energy_j is not None else "continuous")
    in_water = part.beam_half_angle_deg is not None
    angle_deg = 2.0 * part.beam_half_angle_deg if in_water else part.beam_angle_deg
    profile, is_candela = _profile(part.beam_profile, base_dir)
    spectrum_id, spectrum = _spectrum(part.spectrum or ("xenon-flash" if kind == "flash" else ""), base_dir)
    return Light(
        **_identity(part, "light"),
        kind=kind,
        flux_lm=number(part.flux_lm),
        power_w=number(part.power_w),
        output_factor=number(part.output_factor),
        beam=part.beam or ("tabulated" if profile is not None else "cosine-power"),
        beam_angle_deg=number(angle_deg),
        beam_medium="water" if in_water else part.beam_medium or "not stated",
        beam_profile=profile,
        beam_profile_is_candela=is_candela,
        beam_profile_id=part.beam_profile or "",
        spectrum_id=spectrum_id,
        spectrum=spectrum,
        front_radius_mm=part.front_radius_mm,
        dim_levels=part.dim_levels,
        dim_min_frac=part.dim_min_frac,
        dim_status="user",
        min_pulse_us=number(part.min_pulse_us),
        max_pulse_us=number(part.max_pulse_us),
        max_duty_frac=number(part.max_duty_frac),
        max_rate_hz=number(part.max_rate_hz),
        flash_energy_j=number(part.flash_energy_j),
        flash_efficacy_lm_s_per_j=number(part.flash_efficacy_lm_s_per_j),
        flash_duration_us=number(part.flash_duration_us),
        recycle_s=number(part.recycle_s),
        charging_efficiency_frac=number(part.charging_efficiency_frac),
        colour_temperature_k=part.colour_temperature_k,
        depth_rating_m=part.depth_rating_m,
    )


def _identity(part: InlinePart, kind: str) -> dict[str, Any]:
    return {
        "id": part.id or f"inline-{kind}",
        "manufacturer": part.manufacturer or "",
        "model": part.model or f"inline {kind}",
        "inline": True,
        "price": number(part.price),
        "currency": part.currency.upper(),
        "mass_g": number(part.mass_g),
        "source_url": "",
        "note": part.note or "",
    }


def _is_file(name: str) -> bool:
    return name.casefold().endswith(".csv")


def _path(name: str, base_dir: Path | None) -> Path:
    path = Path(name).expanduser() if name.startswith("~") else Path(name)
    return path if path.is_absolute() or base_dir is None else base_dir / path


def _efficiency(value: float | str, colour: str, base_dir: Path | None) -> tuple[str, dict[str, Curve]]:
    channels = ("mono",) if colour == "mono" else ("red", "green", "blue")
    if isinstance(value, float):
        return "", dict.fromkeys(channels, flat_curve(value))
    if _is_file(value):
        from uwopt.catalog.usercurves import read_channels

        found = read_channels(_path(value, base_dir), "qe")
    else:
        value, found = _built_in_efficiency(value)
    if set(channels) <= set(found):
        return value, {channel: found[channel] for channel in channels}
    if "mono" in found:
        return value, dict.fromkeys(channels, found["mono"])
    have, need = ", ".join(sorted(found)), ", ".join(channels)
    raise CatalogError(
        f"quantum_efficiency {value!r} has the channels {have}; a {colour} camera needs {need}."
    )


def _built_in_efficiency(name: str) -> tuple[str, dict[str, Curve]]:
    rows = [(row["curve_id"], row) for row in built_in_rows("qe_curves.csv")]
    keys = {_plain(curve_id): curve_id for curve_id, _ in rows}
    curve_id = keys.get(_plain(name)) or keys.get(_plain("seed-" + name))
    if curve_id is None:
        near = nearest(name, sorted(set(keys.values())))
        hint = f"did you mean {near!r}?" if near else f"known are {', '.join(sorted(set(keys.values())))}."
        raise CatalogError(f"quantum_efficiency {name!r} is no curve; {hint}")
    points: dict[str, list[tuple[float, float]]] = {}
    for row_id, row in rows:
        if row_id == curve_id:
            points.setdefault(row["channel"], []).append((float(row["wavelength_nm"]), float(row["qe"])))
    return curve_id, {channel: _curve(values) for channel, values in points.items()}


def _profile(name: str | None, base_dir: Path | None) -> tuple[Curve | None, bool]:
    if name is None:
        return None, False
    if _is_file(name):
        from uwopt.catalog.usercurves import read_columns

        columns = read_columns(_path(name, base_dir), ("intensity",))
        return Curve(tuple(columns["angle_deg"].tolist()), tuple(columns["intensity"].tolist())), False
    rows = list(built_in_rows("beam_profiles.csv"))
    own = [row for row in rows if _plain(row["profile_id"]) == _plain(name)]
    if not own:
        known = sorted({row["profile_id"] for row in rows})
        raise CatalogError(f"beam_profile {name!r} is unknown; known are {', '.join(known)}, or name a CSV.")
    curve = _curve([(float(row["angle_deg"]), float(row["intensity"])) for row in own])
    return curve, own[0]["unit"] == "candela"


def _spectrum(name: str, base_dir: Path | None) -> tuple[str, Curve | None]:
    if not name:
        return "generic-led", None
    if not _is_file(name):
        return name, None
    from uwopt.catalog.usercurves import read_columns

    columns = read_columns(_path(name, base_dir), ("relative_power",))
    return name, Curve(tuple(columns["wavelength_nm"].tolist()), tuple(columns["relative_power"].tolist()))


def _curve(points: list[tuple[float, float]]) -> Curve:
    return Curve(tuple(x for x, _ in points), tuple(y for _, y in points))


def _plain(name: str) -> str:
    return name.strip().casefold().replace("-", "_").replace(" ", "_")
