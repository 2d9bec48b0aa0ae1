"""swimlab: render sequences under competing shading techniques and tell a stable error from a flickering one.

`sequences` says what is rendered, `metrics` measures frames, and this package renders, runs and reports. Heavy
libraries are imported where they are used, so that importing this package costs nothing.
"""

__version__ = "0.1.0"
__all__ = ["__version__"]
