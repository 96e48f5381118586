"""RGB colours of bodies in scenes; bodies without a colour get the renderer's palette."""

from __future__ import annotations

Rgb = tuple[int, int, int]

GRAPHITE: Rgb = (58, 64, 78)
STEEL: Rgb = (176, 184, 196)
IRON: tuple[Rgb, Rgb] = ((150, 159, 172), (112, 121, 136))
HEMP: tuple[Rgb, Rgb] = ((222, 186, 128), (196, 156, 100))
WOOD: tuple[Rgb, Rgb] = ((196, 146, 94), (172, 120, 74))
BRICK: tuple[Rgb, Rgb, Rgb] = ((196, 92, 66), (176, 76, 58), (210, 112, 84))
WARM: Rgb = (238, 110, 60)
COOL: Rgb = (84, 150, 200)
AMBER: Rgb = (252, 172, 20)
SAGE: Rgb = (140, 188, 112)
PLUM: Rgb = (150, 70, 160)
