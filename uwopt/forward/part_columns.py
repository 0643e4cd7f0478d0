"""Parts as arrays in SI units, ready for the model: one row a part, one column a property.

The catalogue's records carry the field's units and a range for what is estimated; here each number
becomes one column in SI, taken at its central value, or at the end that favours (`good`) or harms
(`bad`) a design. Money is converted once, into the mission's currency.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from uwopt.arrays import Array
from uwopt.forward.columns import PartColumns
from uwopt.forward.flash_times import FlashTimes
from uwopt.model.f_stops import f_number_closed

End = Literal["central", "good", "bad"]
CONTINUOUS, PULSED, FLASH = 0, 1, 2
@dataclass(frozen=True)
class Cameras(PartColumns):
    """Camera columns; `qe_index` points into the list of distinct efficiency curves."""

    resolution_x_px: Array
    resolution_y_px: Array
    pixel_pitch_m: Array
    read_noise_e: Array
    saturation_e: Array
    gain_dn_per_e: Array  # at unit gain, in DN of `bits`
    bits: Array
    black_level_dn: Array
    max_gain: Array
    min_exposure_s: Array
    max_exposure_s: Array
    exposure_offset_s: Array
    dark_current_e_s: Array
    prnu_frac: Array
    max_rate_hz: Array
    readout_s: Array  # 0 for a global shutter
    frame_mb: Array  # 10^6 byte
    qe_index: Array
    qe_scale: Array
    price: Array
    limit_price: Array  # what counts against a budget: the price, or its high end
    mass_kg: Array
    power_w: Array
    standby_w: Array  # where it is switched off between images
    awake_s: Array  # that an image keeps it on then beside its exposure: waking up, the transfer
    body_width_m: Array  # 0 where it is not known, here and below
    body_height_m: Array
    body_length_m: Array
    plug_m: Array
    most_body_m: Array  # (n, 4), high ends of these sizes, for which a housing that is to be made is ordered
    storage_gb: Array  # of its own card; inf where a computer takes the images
    fires_lamps: Array  # with the image
    disk_gb: Array  # of all computers that take the images, in their price; inf: it keeps them on its own card


@dataclass(frozen=True)
class Lenses(PartColumns):
    """Lens columns."""

    focal_length_m: Array
    f_number_min: Array
    f_number_max: Array
    transmission: Array
    min_object_distance_m: Array
    spacers_m: Array  # (n, n_lengths) of rings that may stand behind it, rising, nan-padded
    thread_travel_m: Array
    max_magnification: Array  # on a ring or screwed out
    rated_pitch_m: Array  # pixel pitch that the maker rates the lens for; 0 when unknown
    aberration_f1_m: Array  # that of its aberrations, at f-number 1
    aberration_exponent: Array  # with which their square falls as the iris closes
    motorised: Array
    length_m: Array  # 0 where it is not known
    diameter_m: Array
    pupil_m: Array
    most_body_m: Array  # (n, 2), high ends of diameter and length
    pupil_ends_m: Array  # (n, 2), low and high end of `pupil_m`
    price: Array
    limit_price: Array  # what counts against a budget: the price, or its high end
    mass_kg: Array

    @property
    def one_opening(self) -> Array:
        """Whether the iris cannot be moved: there is nothing to stop down."""
        return np.asarray(self.f_number_max <= self.f_number_min)

    def f_number_from(self, stops_down: float) -> Array:
        """The smallest f-number to use when lenses are closed by so many stops: see `f_number_closed`."""
        widest = self.f_number_min.tolist()
        closed = {each: f_number_closed(each, stops_down) for each in set(widest)}
        return np.where(self.one_opening, self.f_number_min, [closed[each] for each in widest])


@dataclass(frozen=True)
class Ports(PartColumns):
    """Port columns; `outer_radius_m` is 0 for a flat port. Cost and mass are those of the enclosure."""

    is_dome: Array
    outer_radius_m: Array
    thickness_m: Array
    refractive_index: Array
    gap_m: Array
    clear_radius_m: Array  # inf when unknown
    rim_gap_m: Array  # from the lens's entrance pupil to the edge that may cut its view, along the axis
    price: Array
    limit_price: Array  # what counts against a budget: the price, or its high end
    mass_kg: Array
    housed: Array  # whether it is built into a housing
    roomy: Array  # a housing that camera and lens must fit into; that of a complete camera has them inside
    is_sphere: Array  # the housing
    to_be_made: Array  # the housing: it is ordered for the high ends of the sizes that it must hold
    room_diameter_m: Array  # inside the housing; inf where there is none
    room_length_m: Array
    outer_diameter_m: Array  # of the housing with its port
    outer_length_m: Array
    displaced_kg: Array  # of seawater


@dataclass(frozen=True)
class Lights(PartColumns):
    """Light columns, one lamp each. Light of a flash is in lm s, of the others in lm."""

    kind: Array
    full_light: Array  # nameplate lm (continuous, pulsed) or lm s a pulse (flash)
    output_factor: Array
    full_power_w: Array  # continuous, pulsed: while on; flash: 0
    pulse_energy_j: Array  # flash: taken from the supply for one full pulse; others 0
    charging_power_w: Array  # flash: from the supply while it recharges; 0 of others, and where recycling is not known
    stored_energy_j: Array  # flash: in the tube
    levels: Array  # (n, n_levels) shares of full light, NaN-padded; a column of NaN: continuous
    min_level: Array
    dims_freely: Array
    min_pulse_s: Array
    max_pulse_s: Array
    max_duty: Array
    max_rate_hz: Array  # inf when no limit; of a flash 1 / recycle time
    flash_duration_s: Array  # until it is over; unknown of other lamps: inf
    flash_decay_s: Array  # in which it fades to 1/e; inf: it does not, or is no flash
    switchable: Array  # may be off between images
    warm_up_s: Array
    standby_w: Array
    optics_index: Array  # into the list of distinct (beam, spectrum)
    price: Array
    limit_price: Array  # what counts against a budget: the price, or its high end
    mass_kg: Array

    @property
    def flash(self) -> FlashTimes:
        """How the flashes among them fade."""
        return FlashTimes(self.flash_decay_s, self.flash_duration_s)

    @property
    def brightest_lm(self) -> Array:
        """Light of one lamp at full level; of a flash at its peak."""
        return np.where(self.kind == FLASH, self.full_light / self.flash.full_s, self.full_light)


