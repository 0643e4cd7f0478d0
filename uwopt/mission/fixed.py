"""Settings that stay as they are given, while the search chooses the rest."""

from collections.abc import Iterator
from typing import Annotated

from pydantic import AfterValidator, Field

from uwopt.documents.key_types import NUMBER, Section, at_least, refusal

US_PER_MS = 1000.0


def whole_microseconds(value_ms: float | None) -> float | None:
    """A time that cameras can be set to."""
    if value_ms is None:
        return None
    near = round(value_ms * US_PER_MS)
    if near < 1 or abs(value_ms * US_PER_MS - near) > 1e-6:
        mend = f"cameras are set in these; give {max(near, 1) / US_PER_MS:g}"
        raise refusal("is no whole number of microseconds", mend)
    return near / US_PER_MS


class Fixed(Section):
    """Settings by hand, of every scene; what is left out is chosen. Names and meanings are those of a system's."""

    f_number: Annotated[float, Field(gt=0, le=128), at_least(0.1), NUMBER] | None = Field(
        default=None, description="f-number that every lens is set to, as engraved; lenses without it are left out"
    )
    exposure_ms: Annotated[
        Annotated[float, Field(gt=0, le=1e6), NUMBER] | None, AfterValidator(whole_microseconds)
    ] = Field(
        default=None,
        description="exposure in milliseconds that every camera is set to, in whole microseconds; cameras without it "
        "are left out",
    )
    gain: Annotated[float, Field(ge=1, le=1e6), NUMBER] | None = Field(
        default=None, description="gain as a ratio, 1 or above; cameras that do not reach it are left out"
    )
    dim_frac: Annotated[float, Field(gt=0, le=1), at_least(1e-6), NUMBER] | None = Field(
        default=None,
        description="light level of every lamp, a share 0..1 of its full light; lamps without it are left out",
    )

    def given(self) -> Iterator[tuple[str, float]]:
        """What is fixed, by name."""
        for name in type(self).model_fields:
            value = getattr(self, name)
            if value is not None:
                yield name, value
