"""Plots of one design as plain Plotly figures: `data` and `layout`, numbers as lists.

Backgrounds are transparent and no text has a colour: the page sets both for light, dark and paper. Lines
take Okabe and Ito's colours that stand out on white and on near black, and differ in dashes too.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from uwopt.arrays import Array
from uwopt.report.pictures.curves import DepthOfField, Operation, SpectrumWay
from uwopt.report.pictures.maps import FloorMap, ImageMap

Plot = dict[str, Any]

BLUE, VERMILLION, GREEN, PURPLE, GREY = "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#808080"
CHANNEL_COLOURS = {"red": VERMILLION, "green": GREEN, "blue": BLUE}
DASHES = ("dot", "dash", "solid", "dashdot", "longdash")
BAND = "rgba(0,114,178,0.18)"
ALTITUDES = "rgba(128,128,128,0.22)"
CLEAR = "rgba(0,0,0,0)"
LEGEND = {"orientation": "h", "x": 0, "y": 1.02, "yanchor": "bottom"}
DIGITS, MAP_DIGITS = 5, 4
SPECTRUM_STEP = 6  # of the model's grid: curves are smooth at 3 nm
FAR_SHOWN = 4.0  # times the highest altitude; beyond it, the far limit leaves the plot
STOPS = (0.7, 1.0, 1.4, 2.0, 2.8, 4.0, 5.6, 8.0, 11.0, 16.0, 22.0, 32.0, 45.0, 64.0)


def numbers(values: Any, digits: int = DIGITS) -> list[Any]:
    """Nested lists of rounded numbers; what is not finite becomes None."""
    array = np.asarray(values, float)
    if array.ndim > 1:
        return [numbers(row, digits) for row in array]
    return [float(f"{v:.{digits}g}") if np.isfinite(v) else None for v in array]


def axis(title: str, **more: Any) -> dict[str, Any]:
    """An axis with its title and unit."""
    return {"title": {"text": title}, "zeroline": False, "automargin": True, **more}


def layout(*, height: int = 380, **more: Any) -> dict[str, Any]:
    """What all plots share."""
    return {
        "height": height,
        "paper_bgcolor": CLEAR,
        "plot_bgcolor": CLEAR,
        "margin": {"l": 64, "r": 16, "t": 16, "b": 52},
        "legend": dict(LEGEND),
        "hovermode": "closest",
        **more,
    }


def curve(x: Any, y: Any, name: str, colour: str, dash: str = "solid", **more: Any) -> dict[str, Any]:
    """A line."""
    return {
        "type": "scatter", "mode": "lines", "x": numbers(x), "y": numbers(y), "name": name,
        "line": {"color": colour, "width": 2, "dash": dash}, **more,
    }  # fmt: skip


def dot(x: float, y: float, name: str, symbol: str = "circle") -> dict[str, Any]:
    """A marked point."""
    marker = {"color": VERMILLION, "size": 11, "symbol": symbol}
    place = {"x": numbers([x]), "y": numbers([y])}
    return {"type": "scatter", "mode": "markers", **place, "name": name, "marker": marker}


# ---------------------------------------------------------------- light


def spectrum_plot(way: SpectrumWay) -> Plot:
    """Five stages of the light below each other, over one axis of wavelengths."""
    some = slice(None, None, SPECTRUM_STEP)
    stages: list[tuple[str, str, list[tuple[str, Array, str]]]] = [
        ("above the water", "W/m²/nm", [("sun", way.source, PURPLE)]) if way.of_sun else
        ("leaving the lamps", "W/nm", [("lamps", way.source, PURPLE)]),
        ("on the floor", "W/m²/nm", [("floor", way.floor_irradiance_w_m2_nm, PURPLE)]),
        ("reflected", "W/m²/sr/nm", [("reflected", way.reflected_radiance_w_m2_sr_nm, PURPLE)]),
        ("on the sensor", "W/m²/nm", [("sensor", way.sensor_irradiance_w_m2_nm, PURPLE)]),
    ]
    electrons = [
        (name, values, CHANNEL_COLOURS[name]) for name, values in way.channel_electrons_per_nm.items()
    ] or [("pixel", way.electrons_per_nm, BLUE)]
    stages.append(("in a pixel", "electrons/nm", electrons))
    data: list[dict[str, Any]] = []
    axes: dict[str, Any] = {}
    notes = []
    share = 1.0 / len(stages)
    for index, (title, unit, lines) in enumerate(stages):
        number = "" if index == 0 else str(index + 1)
        top = 1.0 - index * share
        axes[f"yaxis{number}"] = axis(
            unit, domain=[round(top - share + 0.02, 4), round(top - 0.03, 4)], rangemode="tozero", nticks=4,
            exponentformat="power",
        )  # fmt: skip
        notes.append({
            "text": title, "x": 1, "y": round(top, 4), "xref": "paper", "yref": "paper", "xanchor": "right",
            "yanchor": "top", "showarrow": False,
        })  # fmt: skip
        for name, values, colour in lines:
            one = curve(way.wavelength_nm[some], values[some], name, colour, showlegend=len(lines) > 1)
            data.append(
                {**one, "xaxis": "x", "yaxis": f"y{number}", "hovertemplate": f"%{{x}} nm: %{{y}} {unit}"}
            )
    last = f"y{len(stages)}"
    return {
        "data": data,
        "layout": layout(
            height=720, annotations=notes, xaxis=axis("wavelength in vacuum [nm]", anchor=last), **axes
        ),
    }


# ---------------------------------------------------------------- sharp


def altitude_shapes(dof: DepthOfField) -> list[dict[str, Any]]:
    """The altitudes that must be sharp, as a band, and the nominal one as a line."""
    across = {"xref": "paper", "x0": 0, "x1": 1, "yref": "y"}
    line = {"color": GREY, "width": 1.5, "dash": "dot"}
    shapes: list[dict[str, Any]] = [
        {"type": "line", **across, "y0": dof.altitude_m, "y1": dof.altitude_m, "line": line}
    ]
    if dof.highest_altitude_m > dof.lowest_altitude_m:
        ends = {"y0": dof.lowest_altitude_m, "y1": dof.highest_altitude_m}
        shapes.append(
            {"type": "rect", **across, **ends, "fillcolor": ALTITUDES, "line": {"width": 0}, "layer": "below"}
        )
    return shapes


def band(x: Array, near: Array, far: Array, top: float) -> list[dict[str, Any]]:
    """Near and far limit with the sharp distances between them."""
    capped = np.minimum(np.where(np.isfinite(far), far, 10.0 * top), 10.0 * top)
    return [
        curve(x, near, "near limit", BLUE),
        curve(x, capped, "far limit", BLUE, "dash", fill="tonexty", fillcolor=BAND),
    ]


def aperture_plot(dof: DepthOfField) -> Plot:
    """Sharp distances over the f-number."""
    top = FAR_SHOWN * dof.highest_altitude_m
    near = float(np.interp(dof.chosen_f_number, dof.f_number, dof.near_m))
    ticks = [stop for stop in STOPS if dof.f_number[0] * 0.99 <= stop <= dof.f_number[-1] * 1.01]
    chosen = {
        "type": "line", "xref": "x", "x0": dof.chosen_f_number, "x1": dof.chosen_f_number, "yref": "paper", "y0": 0,
        "y1": 1, "line": {"color": VERMILLION, "width": 1.5},
    }  # fmt: skip
    return {
        "data": [
            *band(dof.f_number, dof.near_m, dof.far_m, top),
            dot(dof.chosen_f_number, near, f"set: F{dof.chosen_f_number:.3g}"),
        ],
        "layout": layout(
            xaxis=axis("f-number", type="log", tickvals=ticks, ticktext=[f"{stop:g}" for stop in ticks]),
            yaxis=axis("distance in water from the port [m]", range=[0, float(f"{top:.4g}")]),
            shapes=[*altitude_shapes(dof), chosen],
        ),
    }


def focus_plot(dof: DepthOfField) -> Plot:
    """Sharp distances over the focus distance, at the f-number that is set."""
    top = FAR_SHOWN * dof.highest_altitude_m
    data = band(dof.focus_distance_m, dof.near_by_focus_m, dof.far_by_focus_m, top)
    if np.isfinite(dof.chosen_focus_m):
        near = float(np.interp(dof.chosen_focus_m, dof.focus_distance_m, dof.near_by_focus_m))
        data.append(dot(dof.chosen_focus_m, near, f"set: {dof.chosen_focus_m:.3g} m"))
    return {
        "data": data,
        "layout": layout(
            xaxis=axis("focus in water, from the port [m]"),
            yaxis=axis("distance in water from the port [m]", range=[0, float(f"{top:.4g}")]),
            shapes=altitude_shapes(dof),
        ),
    }


# ---------------------------------------------------------------- operation


def altitude_lines(curves: Operation, values: Array) -> list[dict[str, Any]]:
    """One line an altitude; the mission's own is solid and bold."""
    lines = []
    for index, altitude in enumerate(curves.altitude_m):
        own = abs(altitude - curves.mission_altitude_m) < 1e-9
        dash = "solid" if own else DASHES[index % len(DASHES)].replace("solid", "longdash")
        colour = BLUE if own else (GREEN, PURPLE)[index % 2]
        lines.append(curve(curves.speed_m_s, values[index], f"{altitude:.3g} m", colour, dash))
    return lines


def rate_plot(curves: Operation) -> Plot:
    """Frame rate wanted over speed, a line an altitude, with what the camera can do."""
    top = 1.15 * max(float(curves.frame_rate_hz.max()), curves.set_rate_hz)
    shapes = []
    if np.isfinite(curves.camera_rate_hz) and curves.camera_rate_hz < 3.0 * top:
        limit = float(f"{curves.camera_rate_hz:.4g}")
        top = max(top, 1.1 * limit)
        shapes.append({
            "type": "line", "xref": "paper", "x0": 0, "x1": 1, "y0": limit, "y1": limit,
            "line": {"color": VERMILLION, "width": 1.5, "dash": "dash"},
            "label": {"text": f"camera's most: {limit:g} Hz", "textposition": "end"},
        })  # fmt: skip
    data = altitude_lines(curves, curves.frame_rate_hz)
    data.append(dot(curves.mission_speed_m_s, curves.mission_rate_hz, "this mission"))
    if curves.set_rate_hz > curves.mission_rate_hz * 1.001:
        data.append(dot(curves.mission_speed_m_s, curves.set_rate_hz, "as set", "diamond-open"))
    return {
        "data": data,
        "layout": layout(
            legend={**LEGEND, "title": {"text": "altitude:"}},
            xaxis=axis("speed [m/s]"),
            yaxis=axis("least frame rate [Hz]", range=[0, float(f"{top:.4g}")]),
            shapes=shapes,
        ),
    }


def exposure_plot(curves: Operation) -> Plot:
    """Longest exposure by blur over speed, a line an altitude, and the exposure that collects light as set."""
    values = np.where(np.isfinite(curves.exposure_s), curves.exposure_s * 1e3, np.nan)
    row = int(np.argmin(np.abs(curves.altitude_m - curves.mission_altitude_m)))
    own = np.interp(curves.mission_speed_m_s, curves.speed_m_s, np.nan_to_num(values[row], nan=0.0))
    data = altitude_lines(curves, values)
    if own > 0:
        data.append(dot(curves.mission_speed_m_s, float(own), "this mission's limit"))
    data.append(dot(curves.mission_speed_m_s, curves.set_light_time_s * 1e3, "as set", "diamond-open"))
    return {
        "data": data,
        "layout": layout(
            legend={**LEGEND, "title": {"text": "altitude:"}},
            xaxis=axis("speed [m/s]"),
            yaxis=axis(f"exposure for {curves.blur_px:g} px of blur [ms]", type="log", exponentformat="none"),
        ),
    }


# ---------------------------------------------------------------- maps


#: Above the map: beside it, it leaves a telephone no room for the axis below.
BAR = {"orientation": "h", "x": 0.5, "xanchor": "center", "y": 1.0, "yanchor": "bottom", "ypad": 6, "thickness": 14}


def heat(x: Any, y: Any, z: Any, unit: str, *, scale: str) -> dict[str, Any]:
    """A map with its bar."""
    return {
        "type": "heatmap", **{name: numbers(column, MAP_DIGITS) for name, column in (("x", x), ("y", y), ("z", z))},
        "colorscale": scale, "colorbar": {**BAR, "title": {"text": unit, "side": "top"}}, "zsmooth": "best",
        "hovertemplate": f"%{{x}}, %{{y}}: %{{z}} {unit}<extra></extra>",
    }  # fmt: skip


def floor_plot(floor: FloorMap) -> Plot:
    """Illuminance on the floor with the outline of what the camera sees."""
    outline = curve(floor.outline_across_m, floor.outline_along_m, "seen by the camera", VERMILLION)
    return {
        "data": [heat(floor.across_m, floor.along_m, floor.illuminance_lx, "lx", scale="Cividis"), outline],
        "layout": layout(
            height=460,
            xaxis=axis("across the track, to starboard [m]", constrain="domain"),
            yaxis=axis("along the track, forward [m]", scaleanchor="x", constrain="domain"),
        ),
    }


def snr_plot(image: ImageMap) -> Plot:
    """SNR over the image as it is held."""
    return {
        "data": [heat(image.x_px, image.y_px, image.snr_db, "dB", scale="Viridis")],
        "layout": layout(
            height=460,
            xaxis=axis("image width [px]", constrain="domain"),
            yaxis=axis("image height [px]", scaleanchor="x", constrain="domain", autorange="reversed"),
        ),
    }
