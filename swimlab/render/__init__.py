"""From a sequence to pictures. What a technique's file of your own imports stands here, and stays here.

A file that defines TECHNIQUE, in a folder that `swimlab.add_techniques(folder)` or SWIMLAB_TECHNIQUES names:

    from typing import Any

    import warp as wp

    from swimlab.render import Chain, Settings, Surface, Technique, TextureFilter, isotropic, pixel_shading

    @wp.func(module="unique")
    def duller(texels: wp.array(dtype=Any), chain: Chain, surface: Surface):
        texel = isotropic(texels, chain, surface)
        texel[7] = texel[7] / 2.0
        return texel

    TECHNIQUE = Technique(
        name="duller",
        summary="trilinear with half the specular power",
        source="an example",
        render=pixel_shading(lambda settings: TextureFilter(duller)),
        settings=Settings,
    )

- `Technique`, `Picture`, `Settings`: what a technique is, what it gives, and what a user may set.
- `pixel_shading`: filter the inputs at a pixel's centre and shade once. `render_samples`: shade n x n samples a pixel.
- `Shot`: a frame's geometry, material, light and launcher. `Inputs`, `BOX`: what a mip chain holds.
- `TextureFilter`: a filter in its plain form; `FINEST`, `ISOTROPIC`, `anisotropic_to(most)` are the ready ones.
- In a filter: `point`, `bilinear`, `trilinear`, `isotropic` and `anisotropic` sample the chain; `isotropic_level` gives
  the level of detail, `ellipse` the footprint. A texel is albedo (0 to 2), normal (3 to 5), Ks (6) and power (7).
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:  # Warp is heavy: who imports another module of this package need not wait for it here
    from swimlab.render.inputs import BOX, Inputs
    from swimlab.render.kernels.footprint import ellipse, isotropic_level
    from swimlab.render.kernels.sampling import anisotropic, bilinear, isotropic, point, trilinear
    from swimlab.render.kernels.structs import Chain, Surface
    from swimlab.render.kernels.texture_filter import FINEST, ISOTROPIC, TextureFilter, anisotropic_to
    from swimlab.render.settings import Settings
    from swimlab.render.shot import Shot
    from swimlab.render.technique import Picture, Technique, pixel_shading, render_samples

__all__ = [
    "BOX",
    "FINEST",
    "ISOTROPIC",
    "Chain",
    "Inputs",
    "Picture",
    "Settings",
    "Shot",
    "Surface",
    "Technique",
    "TextureFilter",
    "anisotropic",
    "anisotropic_to",
    "bilinear",
    "ellipse",
    "isotropic",
    "isotropic_level",
    "pixel_shading",
    "point",
    "render_samples",
    "trilinear",
]

_NAMES = {
    "inputs": ("BOX", "Inputs"),
    "kernels.footprint": ("ellipse", "isotropic_level"),
    "kernels.sampling": ("anisotropic", "bilinear", "isotropic", "point", "trilinear"),
    "kernels.structs": ("Chain", "Surface"),
    "kernels.texture_filter": ("FINEST", "ISOTROPIC", "TextureFilter", "anisotropic_to"),
    "settings": ("Settings",),
    "shot": ("Shot",),
    "technique": ("Picture", "Technique", "pixel_shading", "render_samples"),
}
_HOMES = {name: f"{__name__}.{module}" for module, names in _NAMES.items() for name in names}


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(_HOMES[name]), name)


def __dir__() -> list[str]:
    return sorted(__all__)
