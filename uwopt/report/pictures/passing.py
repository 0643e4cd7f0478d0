"""What water and camera let pass, by wavelength: attenuation of the scene's water, efficiency of the sensor.

Read from the tables that the model itself uses for a design, on its own grid.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from uwopt.arrays import Array
from uwopt.evaluation.recompute import Replay
from uwopt.forward.spectra import efficiency_curve
from uwopt.forward.views import port_transmission
from uwopt.report.pictures.curves import CHANNELS, is_colour
from uwopt.report.pictures.design_pictures import Picture
from uwopt.report.pictures.plots import (
    BLUE,
    CHANNEL_COLOURS,
    GREEN,
    GREY,
    PURPLE,
    SPECTRUM_STEP,
    VERMILLION,
    Plot,
    axis,
    curve,
    layout,
)


@dataclass(frozen=True)
class WaterCurves:
    """Coefficients of a scene's water [1/m] on one grid."""

    wavelength_nm: Array
    camera_leg_per_m: Array  # c: what leaves the straight way from floor to port
    lamp_leg_per_m: Array  # K: what is lost between lamp and floor
    scattering_per_m: Array | None  # b; None where the table has attenuation alone
    daylight_per_m: Array | None  # K_d
    water: str
    range_m: float

    @property
    def clearest_nm(self) -> float:
        """The wavelength of which most reaches the camera."""
        return float(self.wavelength_nm[int(np.argmin(self.camera_leg_per_m))])


@dataclass(frozen=True)
class SensorCurves:
    """Efficiency of a sensor by channel, and what lens and port pass, as shares 0..1."""

    wavelength_nm: Array
    efficiency: dict[str, Array]  # `mono`, or red, green and blue
    lens_transmission: float
    port_transmission: float  # on the axis, at the design wavelength
    camera: str

    @property
    def peak(self) -> tuple[str, float, float]:
        """Channel, wavelength [nm] and value of the highest efficiency."""
        name = max(self.efficiency, key=lambda one: float(self.efficiency[one].max()))
        at = int(np.argmax(self.efficiency[name]))
        return name, float(self.wavelength_nm[at]), float(self.efficiency[name][at])


def water_curves(design: Replay, scene_index: int) -> WaterCurves:
    """The water of one scene as the model takes it."""
    model = design.model
    scene = model.problem.scenes[scene_index]
    scattered = [part.scattering_per_m for part in scene.scattering]
    of_scene = scene.view.scene
    reading = of_scene.clarity
    return WaterCurves(
        wavelength_nm=scene.wavelength_nm,
        camera_leg_per_m=scene.attenuation_per_m,
        lamp_leg_per_m=model.problem.lamp_leg_per_m(scene_index, model.optics),
        scattering_per_m=np.sum(scattered, axis=0) if scattered else None,
        daylight_per_m=scene.diffuse_attenuation_per_m,
        water=f"{reading[0]} {reading[1]:g}" if reading else f"water {of_scene.water}, table {scene.water_table}",
        range_m=float(scene.range_m[scene.nominal]),
    )


def sensor_curves(design: Replay, scene_index: int) -> SensorCurves:
    """The design's sensor, lens and port as the model takes them."""
    model = design.model
    scene = model.problem.scenes[scene_index]
    curves = model.problem.efficiencies[model.efficiency]
    grid = scene.wavelength_nm
    names = CHANNELS if is_colour(design) else (None,)
    return SensorCurves(
        wavelength_nm=grid,
        efficiency={name or "mono": efficiency_curve(curves, grid, channel=name) for name in names},
        lens_transmission=float(model.lenses.transmission[0]),
        port_transmission=1.0 if scene.paper else port_transmission(model.shapes[scene_index]),
        camera=model.problem.parts.cameras[0].id,
    )


def attenuation_plot(water: WaterCurves) -> Plot:
    """Coefficients over the wavelength, on a logarithmic axis."""
    some = slice(None, None, SPECTRUM_STEP)
    lines: list[tuple[str, Array | None, str, str]] = [
        ("c, floor to camera", water.camera_leg_per_m, BLUE, "solid"),
        ("K, lamp to floor", water.lamp_leg_per_m, VERMILLION, "dash"),
        ("b, scattering", water.scattering_per_m, GREEN, "dot"),
        ("K_d, daylight", water.daylight_per_m, PURPLE, "dashdot"),
    ]
    return {
        "data": [
            curve(water.wavelength_nm[some], np.where(values[some] > 0, values[some], np.nan), name, colour, dash)
            for name, values, colour, dash in lines
            if values is not None
        ],
        "layout": layout(
            xaxis=axis("wavelength in vacuum [nm]"), yaxis=axis("coefficient [1/m]", type="log", exponentformat="none")
        ),
    }


def sensor_plot(seen: SensorCurves) -> Plot:
    """Electrons per photon over the wavelength; lens and port as lines."""
    some = slice(None, None, SPECTRUM_STEP)
    grid = seen.wavelength_nm[some]
    data = [
        curve(grid, values[some], f"sensor, {name}", CHANNEL_COLOURS.get(name, BLUE))
        for name, values in seen.efficiency.items()
    ]
    for name, share, dash in (("lens", seen.lens_transmission, "dash"), ("port", seen.port_transmission, "dot")):
        data.append(curve(grid[[0, -1]], [share, share], f"{name} lets pass", GREY, dash))
    return {
        "data": data,
        "layout": layout(
            xaxis=axis("wavelength in vacuum [nm]"), yaxis=axis("electrons per photon, share passed", range=[0, 1.02])
        ),
    }


def attenuation_picture(water: WaterCurves) -> Picture:
    """What the water takes."""
    both = ", ".join(
        f"{what} {float(values[int(np.argmin(water.camera_leg_per_m))]):.3g} per metre"
        for what, values in (("c", water.camera_leg_per_m), ("K", water.lamp_leg_per_m))
    )
    return Picture(
        "attenuation", "light", "Attenuation of the water",
        f"Coefficients of {water.water}: c counts what leaves the straight way to the camera, K what is lost on the "
        "lamps' way, b all that is scattered, K_d daylight with depth; what the model leaves out is not drawn.",
        f"Clearest at {water.clearest_nm:.0f} nm: {both}.",
        "plotly", attenuation_plot(water),
    )  # fmt: skip


def sensor_picture(seen: SensorCurves) -> Picture:
    """What the camera counts."""
    name, at_nm, value = seen.peak
    return Picture(
        "sensor", "light", "Sensor, lens and port",
        f"Quantum efficiency of {seen.camera} with its window, beside the share that lens "
        f"({100 * seen.lens_transmission:.3g} %) and port ({100 * seen.port_transmission:.3g} % on the axis) let pass.",
        f"Highest efficiency {100 * value:.3g} %, channel {name}, at {at_nm:.0f} nm.",
        "plotly", sensor_plot(seen),
    )  # fmt: skip
