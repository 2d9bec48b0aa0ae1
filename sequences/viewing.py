"""How the frames are looked at, which decides what of their flicker can be seen."""

from pydantic import Field

from .table import Real, Table


class Viewing(Table):
    """The viewer's geometry. It changes no pixel, only measures of visibility."""

    pixels_per_degree: Real = Field(
        40.0,
        gt=0,
        le=1000,
        description="pixels to a degree of visual angle (0..1000); a 24 inch Full HD monitor at 60 cm has 38",
    )
    luminance: Real = Field(
        200.0, gt=0, le=1e5, description="cd/m^2 that radiance 1 is shown with (0..1e5); office monitors: 100 to 300"
    )
