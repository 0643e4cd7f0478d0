"""The mission that `uwopt init` writes, and JSON schemas of missions and systems for editors."""

from __future__ import annotations

from typing import Any

_MISSION = """\
# A mission for uwopt: what the images must be, and what the system may cost.
# Every key carries its unit. A line with # in front shows a default or a choice; take the # away to use it.
name: My survey

# What to optimise: power | cost | mass | snr_db | gsd_mm | contrast | information,
# a weighted sum of several, such as {power: 1, cost: 0.01}, or best_image: the most information for its price, until
# one more watt or 100 USD more buy less than 1 % ({best_image: {per_w: 0.02, per_100_usd: 0.005}} for other gains).
objective: power

# Physics of the model: auto leaves out what this scene does not need, full keeps all, paper keeps it plain.
physics: auto
# tolerance: 0.005             # error that auto may make, a share

# What a key that is left out asks for. recommended: good practice, that is light and sharpness over the whole image
# (snr_at, dof_at, min_uniformity), a lens one stop down, reserves, and nothing that an expert would refuse.
# bare: nothing. A key that is given holds either way.
practice: recommended          # the default
# seed: 0

# Where it works. Several places that one system must serve: write `scenes:` and a list.
scene:
  c_per_m: 0.25                # beam attenuation at 530 nm, measured where it will work; or visibility_m (a black disc
                               # seen horizontally), secchi_m or turbidity_ntu: ranges come with these
  # water: II                  # instead: Jerlov type I IA IB II III 1C 3C 5C 7C 9C, or a CSV profile; of a type two
                               # published tables differ so much that few systems serve both
  # water_table: measured      # measured | solonenko-mobley
  seafloor: coral              # sand | hard | coral | organic | benthic-average | 0..1 | a CSV spectrum
  # target: floor              # wall | mid_water: looked at level; mid_water has open water behind its targets;
                               # ceiling: ice, a hull or a roof above; depth_m is the camera's then
  depth_m: 30
  # temperature_c: 10
  # salinity_psu: 35           # 0 for fresh water
  # backscatter_ratio: 0.0183  # share of the scattering that goes backward
  # multiple_scattering: true  # false: count light that is scattered twice as lost
  # phase_function: fournier-forand  # henyey-greenstein | petzold-<station> | a CSV (angle_deg, phase_per_sr)
  # sun_lux: 0                 # sunlight at the surface; 100000 on a bright day, 0 at night
  # sun_elevation_deg: 60
  # subject_speed_m_s: 0       # of what swims there, in any direction: it blurs in the exposure as speed does
  # time_share: 1.0            # with several scenes: share of the time spent here, for energy and storage

# How the camera is carried, and which hardware may be tried.
vehicle:
  altitude_m: 2.0              # from the port to the floor; or distance_m, of a wall, ceiling or target
  altitude_tolerance_m: 0.25   # every requirement holds over altitude +/- tolerance
  speed_m_s: 0.5               # 0 when it hovers; then give requirements.frame_interval_s
  # pitch_deg: 0               # how far the camera looks ahead of straight down, and the lamps with it
  # pitch_rate_deg_s: 0
  # roll_rate_deg_s: 0
  orientation: any             # landscape | portrait | any: image height | width along the motion
  # camera_count: 2            # 1 unless given
  # camera_baseline_m: 0.5     # of a stereo pair, across track between the ports
  # camera_convergence_deg: 8  # between its axes, half of it each inward
  light_count: [1, 4]          # a number, or [least, most]
  light_baseline_m: 0.8        # across track from port to lights: a number, or [least, most]
  # light_tilt_deg: 0          # outward tilt: a number, or [least, most]
  # light_mounts:              # instead of baseline and tilt: place and aim of each light
  #   - {x_m: 0.3, y_m: 0.8, z_m: 0, tilt_x_deg: 0, tilt_y_deg: 10}
  # lamp_size_m: 0.1           # a lamp's body: none may stand in another or in the port
  # duration_h: 8              # how long it takes: energy and storage are counted over it
  # battery_wh: 500            # for the figure endurance
  # supply: vehicle            # battery: one of battery_wh is part of the system, in cost, mass and what it may use up
  # cable_m: 20                # from each camera to the common computer; USB3 reaches 5 m, network 100 m
  # lamp_supply: external      # by good practice: fed by the vehicle; battery: divers' torches; any
  # lamps_between_images: on   # on | off: recommended off below an image in some seconds
  # camera_between_images: on  # on | off: recommended off below an image a minute

# What the images must be. A requirement that is left out asks for nothing, but for what good practice asks.
requirements:
  overlap: 0.6                 # along track, a share 0..1
  # frame_interval_s: 2
  max_blur_px: 1.0
  # max_skew_px: 2             # of a rolling shutter
  min_dof_m: 0.6               # depth of field
  # dof_at: corner             # by good practice: sharp over the frame; axis: in its middle alone
  # circle_of_confusion_px: 2
  min_snr_db: 25               # or min_snr, a ratio
  # min_snr_red_db: 15         # of the red channel alone; asks for a colour sensor
  # snr_at: worst              # by good practice: 95 % of the frame reach it; worst_px: the darkest pixel; mean
  # snr_at_less_db: 6          # those pixels may have so much less, and the image's mean reaches min_snr_db
  max_gsd_mm: 1.0              # largest pixel on the floor
  # min_swath_m: 1.0
  # max_depth_error_mm: 10     # of a stereo pair: standard error of a distance
  # disparity_error_px: 0.5    # that it is reckoned with
  # min_common_swath_m: 1.0    # of a stereo pair: seen by both cameras
  # min_area_m2_h: 1000        # covered in an hour, the sidelap taken off
  # sidelap: 0.2                # of neighbouring lines, a share 0..1
  mean_level: 0.3              # wanted mean image level, share of full scale; the gain is chosen for it
  # max_gain_db: 12            # that no design may exceed; reserve.max_gain_db yields where nothing fits
  # highlight_ratio: 1.5       # brightest detail over the mean, must not saturate
  # min_contrast: 0.5          # image-forming light over all light
  # min_uniformity: 0.3        # by good practice, with lamps: darkest over mean illuminance of the floor
  # min_mtf_half_nyquist: 0.3  # by good practice: what the finest bars that mosaics live on keep of their contrast
  # max_white_balance: 4       # strongest over weakest colour channel; refuse: all holds 4
  # resolve_mm: 2              # bars this wide on the floor arrive with a tenth of their contrast, in the corner too
  # shutter: any               # any | global | rolling
  colour: any                  # colour: a sensor that sees colours; mono: it needs less light and sees finer detail;
                               # any: whichever is best, which mostly is mono
  # lens_stop_down: 1          # by good practice: stops that the lens is closed from its widest opening
  # max_airy_px: 2             # diffraction: diameter of the Airy disc
  # refuse: all                # by good practice; or a list of airy | skew | swath | depth | lamp | white_balance

# Reserves: by how much each requirement is to be exceeded; by good practice as here.
# reserve:
#   snr_db: 3
#   blur: 0.2                  # shares of what is asked
#   swath: 0.1
#   dof: 0.1
#   depth: 1.25                # depth rating over the depth asked
#   max_gain_db: 12            # more gain stands in for light; lifted with a warning where nothing fits
#   energy: 0.2                # share of a battery of the system's own (supply: battery) that stays unused
#   tilt_deg: 3                # how far each lamp may lean in or out

# How certain the recommendation is to be: the share of the scenarios of what is uncertain in which the hardware must
# hold, central (every number at its central value), or ends (the worst of all ends).
# confidence: 0.9              # by good practice
# doubt:                       # what the scenarios draw beside the numbers of parts that are estimates
#   parts: yes                 # those
#   clarity: yes               # what a reading such as visibility_m leaves open
#   lamp_leg: yes              # K on the way from lamp to floor, by what is lost of scattered light
#   other_water_table: 0.5     # probability that the other published table of the Jerlov types holds
#   floor: [0.8, 1.25]         # factor on its reflectance; [1, 1]: it is known
#   lamp_output: [0.85, 1.07]  # factor on the lumens that makers state
#   beyond_band: 0.25          # how far the vehicle leaves its band, as a share of altitude_tolerance_m; 0: never
#   focus: [0.98, 1.02]        # factor on the distance to which a lens is focused before its port is sealed
#   settings: adapt            # or fixed: exposure, gain and light level before the water is seen, too
#   scenarios: 256

# What the system may cost, draw and weigh. A limit that is left out limits nothing.
limits:
  cost: 20000
  currency: USD
  # rates: {EUR: 1.15}         # your exchange rates, USD per unit
  # cost_basis: high           # high | central: the end of estimated prices that must fit
  power_w: 150
  # peak_power_w: 500
  # energy_wh: 400             # over vehicle.duration_h
  # storage_gb: 1000           # of uncompressed images, over vehicle.duration_h
  # mass_kg: 20
  # mass_water_kg: 5           # of the cameras in their housings, lamps not counted
  # size_mm: 600               # largest length or diameter of a housing
  # diameter_mm: 200           # largest diameter of a housing, however long: of a borehole or a hatch
  depth_rating_m: 100          # left out: the deepest scene
  # data_rate_mb_s: 100
  # max_exposure_ms: 1000

# Settings that stay as given in every scene, while the rest is chosen.
# fixed:
#   f_number: 4                # as engraved
#   exposure_ms: 1             # in whole microseconds
#   gain: 1                    # a ratio
#   dim_frac: 1                # light level of every lamp, a share of its full light

# Which parts may be used. Patterns fit an id or a maker: a plain part of the name, or a glob.
catalog:
  cameras: ["*"]
  # lenses: [kowa, "fujinon*"]
  # ports: [blue_robotics]
  # lights: ["*"]
  # housings: ["*"]
  # complete: also             # also | only | none: cameras bought with lens and port in one housing
  # complete_cameras: ["*"]
  # exclude: []
  # files: [my_parts.csv]      # own parts, or a log of changes, relative to this file
  # prices: my_quotes.csv      # own quotes that override prices
  # owned: [{id: some_part_id, quantity: 1}]   # cost nothing
  # generic: fallback          # parts that no shop sells as such: fallback takes them where nothing sold fits, of as
                               # few kinds as serve; allow | never, or kinds that may be made, as [housing, port]
  # verified: [price]          # fields that must come from a source
  # accept_unrated: []         # ids whose unknown depth rating you accept
  # port_mounts: [nauticam-n120]  # mounts of photo housings that you have an adapter for
  # lens_rating: warn          # warn | limit: lenses rated for larger pixels than the camera's
  # interfaces: [USB3, GigE]   # those that the host has; left out: all
  # availability: any          # known: without parts of which nobody says whether they are still sold
  # host: estimate             # by good practice: the computer that takes the images, by the camera's interface; none
  # rest: estimate             # by good practice: connectors, cables, triggers, battery, spares, pressure test; none
  # spacers: allow             # by good practice: rings behind lenses that must focus nearer than they can; none
  # housing: required          # by good practice: one that takes port, camera and lens is chosen and counted; none
  # extras: [{name: cables, cost: 900, mass_kg: 2.5, power_w: 0}]
"""

_SYSTEM = """\
# A system for `uwopt evaluate`. A part is the id of a catalogue part, or a record in braces.
name: My rig
camera: {resolution_x_px: 2448, resolution_y_px: 2048, pixel_pitch_um: 3.45, read_noise_e: 2.4,
         saturation_e: 10900, quantum_efficiency: 0.6}
lens: {focal_length_mm: 8, f_number_min: 1.4, f_number_max: 16, transmission: 0.9}
port: {geometry: dome, outer_radius_mm: 100, thickness_mm: 10, refractive_index: 1.5}
light: {luminous_flux_lm: 20000, power_w: 200, beam: disc, beam_half_angle_deg: 45}   # half-angle in water
light_count: 1
orientation: portrait          # landscape | portrait
settings:
  f_number: 4.0                # left out: wide open
  exposure_ms: 0.86            # left out: the longest allowed
  gain: 1.0                    # a ratio, 1 is 0 dB
  flux_lm: 20000               # all lights together; or dim_frac, or flash_energy_j
  # pulse_ms: 0.86             # left out: the exposure
  # frame_rate_hz: 2           # left out: the least that is needed
  # focus_distance_m: 2.0      # left out: the nominal altitude; of several scenes the one that serves all
"""


def mission_template() -> str:
    """A mission with comments that loads as it stands."""
    return _MISSION


def system_template() -> str:
    """A system with comments that loads as it stands."""
    return _SYSTEM


def mission_json_schema() -> dict[str, Any]:
    """JSON schema of a mission file: `scene` or `scenes`, and what a scene may override."""
    from uwopt.mission.checks import HARDWARE_KEYS, WHOLE_MISSION_KEYS
    from uwopt.mission.keys import CLARITY_KEYS, OTHER_NAMES
    from uwopt.mission.mission import Mission

    schema = Mission.model_json_schema(by_alias=True)
    definitions = schema["$defs"]
    scene = definitions["Scene"]
    for override in ("VehicleOverride", "RequirementsOverride"):
        properties = definitions[override]["properties"]
        for key in (*HARDWARE_KEYS, *WHOLE_MISSION_KEYS):
            properties.pop(key, None)
        scene["properties"] |= {
            key: value for key, value in properties.items() if key not in scene["properties"]
        }
    count = definitions["Vehicle"]["properties"]["light_count"]
    pair = {key: count.pop(key) for key in ("type", "prefixItems", "minItems", "maxItems")}
    count["anyOf"] = [{"type": "integer", "minimum": 1}, pair]
    schema["properties"]["scene"] = {
        "$ref": "#/$defs/Scene",
        "description": "the one scene, instead of scenes",
    }
    for other, usual in OTHER_NAMES.items():
        for properties in (definitions["Vehicle"]["properties"], definitions["VehicleOverride"]["properties"]):
            properties[other] = properties[usual]
        scene["properties"][other] = scene["properties"][usual]
    definitions["Vehicle"]["required"] = [key for key in definitions["Vehicle"]["required"] if key != "altitude_m"]
    definitions["Vehicle"]["anyOf"] = [{"required": ["altitude_m"]}, {"required": ["distance_m"]}]
    scene["anyOf"] = [{"required": [key]} for key in ("water", *CLARITY_KEYS)]
    schema["required"] = [key for key in schema["required"] if key != "scenes"]
    schema["oneOf"] = [{"required": ["scene"]}, {"required": ["scenes"]}]
    return _titled(schema, "uwopt mission")


def system_json_schema() -> dict[str, Any]:
    """JSON schema of a system file, with the other names that inline records may use."""
    from uwopt.catalog.inline import INLINE_MODELS, SYNONYMS
    from uwopt.mission.system import System

    schema = System.model_json_schema(by_alias=True)
    for kind, model in INLINE_MODELS.items():
        definition = schema["$defs"][model.__name__]
        for other, name in SYNONYMS[kind].items():
            definition["properties"][other] = definition["properties"][name]
            if name in definition.get("required", []):
                definition["required"].remove(name)
                definition.setdefault("allOf", []).append({"anyOf": []})
        for clause in definition.get("allOf", []):
            names = [o for o, n in SYNONYMS[kind].items() if n == "quantum_efficiency"]
            clause["anyOf"] = [{"required": [key]} for key in ("quantum_efficiency", *names)]
    return _titled(schema, "uwopt system")


def _titled(schema: dict[str, Any], title: str) -> dict[str, Any]:
    plain = _without_titles(schema)
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", "title": title, **plain}


def _without_titles(node: Any) -> Any:
    """A schema without the titles that only repeat a key in other letters."""
    if isinstance(node, list):
        return [_without_titles(item) for item in node]
    if not isinstance(node, dict):
        return node
    return {
        key: _without_titles(value)
        for key, value in node.items()
        if key != "title" or isinstance(value, dict)
    }
