"""What the images must be: the section `requirements` of a mission."""

import math
from typing import Annotated, Literal

from pydantic import AfterValidator, BeforeValidator, Field

from uwopt.documents.key_types import (
    CHOICE,
    NUMBER,
    OUT_OF_REACH,
    NonNegative,
    Positive,
    Section,
    Share,
    at_least,
    refusal,
)
from uwopt.mission import keys as words
from uwopt.units import db_to_ratio

#: What a pixel that is as wide as its pitch leaves by itself at half the Nyquist frequency: sinc(1/4).
PIXEL_MTF = 2.0 * math.sqrt(2.0) / math.pi


def _left_by_pixels(value: float) -> float:
    """A transfer at half the Nyquist frequency that some lens might leave."""
    if value > PIXEL_MTF:
        raise refusal(
            f"is more than any camera leaves, with whatever lens: its pixels alone leave {PIXEL_MTF:.3f} at half the "
            "Nyquist frequency", "ask for less; 0.3 is recommended", OUT_OF_REACH,
        )  # fmt: skip
    return value


class Requirements(Section):
    """What the images must be; a key that is left out asks for nothing."""

    overlap: Annotated[float, Field(ge=0, lt=1), NUMBER] | None = Field(
        default=None,
        description="overlap of following images along track, a share 0..1; without it and frame_interval_s 0, images "
        "that just touch",
    )
    frame_interval_s: Positive | None = Field(
        default=None, description="longest time between images in seconds"
    )
    max_blur_px: Positive | None = Field(default=None, description="longest motion blur in pixels")
    max_skew_px: Positive | None = Field(default=None, description="largest rolling-shutter skew in pixels")
    min_dof_m: NonNegative | None = Field(
        default=None, description="least depth of field in metres; without it the nominal altitude is sharp"
    )
    dof_at: Annotated[Literal["axis", "corner"], CHOICE] = Field(
        default="axis",
        description="where in the image the depth of field must hold: axis, or corner (the field at 80 % of the half "
        "diagonal as well; recommended)",
    )
    circle_of_confusion_px: Annotated[float, Field(gt=0, le=1e6), at_least(1e-3), NUMBER] | None = Field(
        default=None,
        description="sharpness limit in pixels; 2, in physics paper the sensor's diagonal / 1500",
    )
    min_snr_db: Annotated[float, Field(ge=-40, le=200), NUMBER] | None = Field(
        default=None,
        description="least signal-to-noise ratio in decibels (20 log10), instead of min_snr; 20 is recommended where "
        "neither is given",
    )
    min_snr_given: Annotated[float, Field(gt=0, le=1e10), NUMBER] | None = Field(
        default=None,
        alias="min_snr",
        description="least signal-to-noise ratio as a ratio, instead of min_snr_db",
    )
    min_snr_red_db: Annotated[float, Field(ge=-40, le=200), NUMBER] | None = Field(
        default=None,
        description="least signal-to-noise ratio of the red channel in decibels, mean of the image; asks for a colour "
        "sensor",
    )
    snr_at: Annotated[Literal["mean", "worst", "worst_px"], CHOICE] = Field(
        default="mean",
        description="where in the image the SNR must hold: mean, worst (95 % of the frame reach it; recommended) "
        "or worst_px (the darkest pixel)",
    )
    snr_at_less_db: Annotated[float, Field(ge=0, le=40), NUMBER] = Field(
        default=0.0,
        description="decibels by which the pixels that snr_at names may have less than min_snr_db, which the image's "
        "mean has then to reach",
    )
    max_gsd_mm: Positive | None = Field(default=None, description="largest pixel on the floor in millimetres")
    min_swath_m: NonNegative | None = Field(
        default=None, description="least footprint across track in metres"
    )
    max_depth_error_mm: Positive | None = Field(
        default=None,
        description="largest standard error of a point's distance by a stereo pair in millimetres, over the strip that "
        "both cameras see; needs vehicle.camera_baseline_m",
    )
    disparity_error_px: Annotated[float, Field(gt=0, le=100), at_least(1e-4), NUMBER] = Field(
        default=0.5,
        description="standard error of a point's disparity, the difference of its places in both images, in pixels: "
        "0.1 to 0.3 of good texture matched by program, 0.5 to 1 of points set by hand",
    )
    min_common_swath_m: NonNegative | None = Field(
        default=None,
        description="least width across track that both cameras of a stereo pair see, in metres; needs "
        "vehicle.camera_baseline_m",
    )
    sidelap: Annotated[float, Field(ge=0, lt=1), NUMBER] = Field(
        default=0.0,
        description="overlap of neighbouring lines across track, a share 0..1; of a stereo pair, of what both cameras "
        "see",
    )
    min_area_m2_h: Positive | None = Field(
        default=None,
        description="least area covered in an hour in square metres, sidelap taken off and turns left out; of a stereo "
        "pair, seen by both cameras",
    )
    mean_level: Annotated[float, Field(gt=0, lt=1), NUMBER] | None = Field(
        default=None,
        description="wanted mean image level, a share 0..1 of full scale; the gain is chosen for it",
    )
    max_gain_db: Annotated[float, Field(ge=0, le=120), words.number_or_recommended(12.0)] | None = Field(
        default=None,
        description="highest gain in decibels above the camera's lowest, recommended 12; reserve.max_gain_db is one "
        "that yields where nothing fits",
    )
    highlight_ratio: Annotated[float, Field(ge=1, le=1000), NUMBER] = Field(
        default=1.5, description="brightest detail over mean level, at least 1, that must not saturate"
    )
    min_contrast: Share | None = Field(
        default=None, description="least image-forming over all light, a share 0..1"
    )
    min_uniformity: Share | None = Field(
        default=None, description="least over mean floor illuminance, a share 0..1"
    )
    min_mtf_half_nyquist: Annotated[Share, AfterValidator(_left_by_pixels)] | None = Field(
        default=None,
        description="least MTF at half the Nyquist frequency, 0..0.9 (pixels leave no more), recommended 0.3",
    )
    max_white_balance: Annotated[float, Field(ge=1, le=1e6), words.number_or_recommended(4.0)] | None = Field(
        default=None,
        description="largest ratio between the strongest and the weakest colour channel of a grey floor, at least 1, "
        "recommended 4; a mono sensor has none",
    )
    resolve_mm: Positive | None = Field(
        default=None,
        description="bars this wide on the floor, in millimetres, arrive with a contrast of a tenth in the corner, "
        "veil counted where snr_at counts; implies pixels no larger and an SNR of 20 dB",
    )
    shutter: Annotated[Literal["any", "global", "rolling"], CHOICE] = Field(
        default="any", description="shutter of the camera: any, global or rolling"
    )
    colour: Annotated[Literal["any", "mono", "colour"], CHOICE] = Field(
        default="any", description="sensor of the camera: any, mono or colour"
    )
    lens_stop_down: Annotated[float, Field(ge=0, le=10), words.number_or_recommended(1.0)] = Field(
        default=0.0,
        description="stops that the lens is closed from its widest opening at least, recommended 1; "
        "a lens of one opening is taken as it is",
    )
    max_airy_px: Annotated[Positive, words.number_or_recommended(2.0)] | None = Field(
        default=None, description="largest diameter of the Airy disc in pixels, recommended 2"
    )
    refuse: Annotated[tuple[words.Refusal, ...], BeforeValidator(words.to_refusals)] = Field(
        default=(),
        description="list of what an expert would refuse, each held as if its key were given: airy (max_airy_px 2), "
        "skew (max_skew_px 2), swath (min_swath_m 1 in a survey with overlap), depth (reserve.depth 1.1), "
        "lamp (in the camera's view), white_balance (max_white_balance 4); all for all (recommended)",
    )

    @property
    def min_snr_red(self) -> float | None:
        """The least signal-to-noise ratio of the red channel; None when none was asked for."""
        return None if self.min_snr_red_db is None else db_to_ratio(self.min_snr_red_db)

    @property
    def min_snr_there(self) -> float | None:
        """The least signal-to-noise ratio of the pixels that `snr_at` names; None when none was asked for."""
        return None if self.min_snr is None else self.min_snr / db_to_ratio(self.snr_at_less_db)

    @property
    def asks_sharpness(self) -> bool:
        """Whether a contrast of fine detail is asked for."""
        return self.min_mtf_half_nyquist is not None or self.resolve_mm is not None

    @property
    def min_snr(self) -> float | None:
        """The least signal-to-noise ratio, whichever way it was asked for; None when it was not."""
        return db_to_ratio(self.min_snr_db) if self.min_snr_db is not None else self.min_snr_given
