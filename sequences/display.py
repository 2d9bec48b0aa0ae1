"""How radiance becomes what a display is sent, for measures of displayed pictures."""

from typing import Annotated, Literal

from pydantic import Field, ValidationInfo, field_validator

from .table import Real, Table, Whole

Bits = Annotated[Whole, Field(ge=1, le=16)]


class Bloom(Table):
    """Bright light that is spread about where it fell; none of it is lost."""

    strength: Real = Field(0.0, ge=0, le=1, description="share of the bright light that is spread (0..1); 0: no bloom")
    threshold: Real = Field(1.0, ge=0, le=1e6, description="exposed radiance above which light is bright")
    radius: Real = Field(
        0.03, gt=0, le=1, description="standard deviation of the widest Gaussian, as a share of the picture's height"
    )


class Display(Table):
    """Exposure, bloom, tone map and gamma (or a view), and quantisation, in this order.

    It changes no pixel of a rendered frame.
    """

    exposure: Real = Field(0.0, ge=-20, le=20, description="stops (-20..20); one more is twice as bright")
    bloom: Bloom = Field(default=Bloom(), description="what bright light does to its neighbourhood")
    tone_map: Literal["none", "reinhard", "aces"] = Field(
        "none", description="how bright light is brought under 1: clamped (none), by reinhard, or by a fit of aces"
    )
    gamma: Literal["srgb", "sqrt"] = Field("srgb", description="from light to codes: sRGB's curve, or the square root")
    view: str | None = Field(
        None,
        pattern="^[^/]+/.+$",
        description="DISPLAY/VIEW of OpenColorIO's configuration, in place of tone_map and gamma (swimlab list views)",
    )
    bits: Bits | None = Field(None, description="bits of a code (1..16); without this key codes are not quantised")
    dither: bool = Field(False, strict=True, description="add a noise of one code before quantising; needs bits")

    @field_validator("view")
    @classmethod
    def _alone(cls, value: str | None, info: ValidationInfo) -> str | None:
        if value is not None and (info.data.get("tone_map"), info.data.get("gamma")) != ("none", "srgb"):
            raise ValueError("a view has a tone map and a gamma of its own: remove tone_map and gamma, or this key")
        return value

    @field_validator("dither")
    @classmethod
    def _only_with_bits(cls, value: bool, info: ValidationInfo) -> bool:
        if value and "bits" in info.data and info.data["bits"] is None:
            raise ValueError("there are no steps to dither: set bits, as 8, or remove this key")
        return value
