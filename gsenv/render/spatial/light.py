"""Row kernel of shading: sun, sky, reflections, fog and tone mapping."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gsenv.render.spatial.depth import Ray
from gsenv.render.spatial.records import (
    BLUE,
    DEPTH,
    GREEN,
    HALF,
    ID,
    NORMAL_X,
    NORMAL_Y,
    NORMAL_Z,
    ONE,
    PIXEL_X,
    RED,
    SHADOW,
    TWO,
    VISIBILITY,
    ZERO,
    FloatArray,
    f4,
)
from gsenv.render.spatial.surface import smooth
from gsenv.solver.jit import inline_njit, njit

GLOSS = f4(0.10)  # strength of the sun's specular highlight
SHEEN = f4(0.22)  # strength of the sky's reflection at grazing angles
SHOULDER = f4(0.80)  # screen colours up to this value are not compressed
TERMINATOR = f4(6.0)  # how fast shadows fade on surfaces that turn away from the sun


@inline_njit
def tone(x: Any) -> Any:
    """Map linear light to a screen colour: its square root, compressed above SHOULDER by a parabola that ends at 1."""
    y = min(np.sqrt(max(x, ZERO)), TWO - SHOULDER)
    over = max(y - SHOULDER, ZERO)
    return y - over * over * f4(0.25 / (1.0 - SHOULDER))


@inline_njit
def find_world_ray(look: Any, y: Any) -> Ray:
    """Return the rays of the row at picture height y in the world's axes."""
    x, step = look.left, look.step
    return (
        look.forward_x + x * look.right_x + y * look.up_x,
        look.forward_y + x * look.right_y + y * look.up_y,
        look.forward_z + x * look.right_z + y * look.up_z,
        step * look.right_x,
        step * look.right_y,
        step * look.right_z,
    )


@inline_njit
def to_byte(value: Any) -> Any:
    return np.uint8(np.int32(value * f4(255.0) + HALF))


@inline_njit
def light_channel(albedo: Any, sun: Any, sunlight: Any, up: Any, sky: Any, bounce: Any, visible: Any) -> Any:
    """Return the diffuse light of one colour channel: of the sun, of the sky and of light that the ground reflects."""
    return albedo * (sun * sunlight + visible * (bounce + up * (sky - bounce)))


@njit
def light_band(
    band: FloatArray,
    start: int,
    end: int,
    looks: NDArray[np.void],
    image: NDArray[np.uint8],
    ids: NDArray[np.int32],
    colors: FloatArray | None,
) -> None:
    """Shade the rows start..end-1; write bytes to `image` and colours in 0..1 to `colors` (3, row, column)."""
    look = looks[0]
    lx, ly, lz = look.sun_x, look.sun_y, look.sun_z
    for row in range(start, end):
        lines = band[row - start]
        ax, ay, az, bx, by, bz = find_world_ray(look, look.top - (f4(row) + HALF) * look.step)
        for j in range(np.uint64(0), np.uint64(lines.shape[1])):
            c, t = lines[PIXEL_X, j], lines[DEPTH, j]
            sky = lines[ID, j] < ZERO
            dx, dy, dz = ax + c * bx, ay + c * by, az + c * bz
            length = np.sqrt(dx * dx + dy * dy + dz * dz)
            scale = ONE / length
            vx, vy, vz = dx * scale, dy * scale, dz * scale
            nx, ny, nz = lines[NORMAL_X, j], lines[NORMAL_Y, j], lines[NORMAL_Z, j]
            facing = nx * lx + ny * ly + nz * lz
            lit = (ONE - min(lines[SHADOW, j], ONE)) * smooth(facing * TERMINATOR)
            sun = max(facing, ZERO) * lit
            up = HALF + HALF * nz
            visible = lines[VISIBILITY, j]
            seen = max(-(nx * vx + ny * vy + nz * vz), ZERO)
            graze = ONE - seen
            graze *= graze
            sheen = SHEEN * graze * graze * (ONE - seen) * visible * (ONE - nz * nz * nz * nz)
            hx, hy, hz = lx - vx, ly - vy, lz - vz
            half = max(nx * hx + ny * hy + nz * hz, ZERO) / np.sqrt(max(hx * hx + hy * hy + hz * hz, f4(1e-6)))
            half *= half
            half *= half
            half *= half
            half *= half
            shine = GLOSS * half * half * lit
            fog = t * length * look.fog
            fog = fog * fog * fog
            fog = fog / (ONE + fog)
            rise = ONE - min(max(vz * f4(1.5), ZERO), ONE)
            rise = ONE - rise * rise
            red = light_channel(lines[RED, j], sun, look.sun_red, up, look.sky_red, look.bounce_red, visible)
            green = light_channel(lines[GREEN, j], sun, look.sun_green, up, look.sky_green, look.bounce_green, visible)
            blue = light_channel(lines[BLUE, j], sun, look.sun_blue, up, look.sky_blue, look.bounce_blue, visible)
            air_red = look.horizon_red + rise * (look.zenith_red - look.horizon_red)
            air_green = look.horizon_green + rise * (look.zenith_green - look.horizon_green)
            air_blue = look.horizon_blue + rise * (look.zenith_blue - look.horizon_blue)
            red = tone(red + shine + sheen * look.sky_red)
            green = tone(green + shine + sheen * look.sky_green)
            blue = tone(blue + shine + sheen * look.sky_blue)
            lines[RED, j] = air_red if sky else red + fog * (air_red - red)
            lines[GREEN, j] = air_green if sky else green + fog * (air_green - green)
            lines[BLUE, j] = air_blue if sky else blue + fog * (air_blue - blue)
        for j in range(np.uint64(0), np.uint64(image.shape[1])):
            ids[row, j] = np.int32(lines[ID, j])
            image[row, j, 0] = to_byte(lines[RED, j])
            image[row, j, 1] = to_byte(lines[GREEN, j])
            image[row, j, 2] = to_byte(lines[BLUE, j])
        if colors is not None:
            for j in range(np.uint64(0), np.uint64(image.shape[1])):
                colors[0, row, j] = lines[RED, j]
                colors[1, row, j] = lines[GREEN, j]
                colors[2, row, j] = lines[BLUE, j]
