"""matplotlib without a display, and the look that all plots share. Import pyplot from here."""

from __future__ import annotations

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

GRID_COLOR = "#e8e8e8"

__all__ = ["GRID_COLOR", "Axes", "Figure", "plain_axes", "plt"]


def plain_axes(axes: Axes, grid: str = "both") -> None:
    """Remove the frame at the top and the right; draw a light grid below the data, along "x", "y" or "both"."""
    axes.grid(axis=grid, color=GRID_COLOR)  # type: ignore[arg-type]
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)
