# SPDX-License-Identifier: Apache-2.0
"""Closed forms and quadratures of the exact tests. Independent of the renderer: nothing here traces its rays.

Sources: Fresnel's formulae; Born and Wolf, Principles of Optics, 1.5; the nephroid as catacaustic of the circle
(MathWorld, "Circle Catacaustic"); images in plane mirrors."""
import numpy as np


def fresnel(cos_i, n):
    """Unpolarised reflectance of an interface into index n (relative), by numpy arrays."""
    sin_t2 = (1 - cos_i**2) / n**2
    cos_t = np.sqrt(np.maximum(0, 1 - sin_t2))
    s = (cos_i - n * cos_t) / (cos_i + n * cos_t)
    p = (n * cos_i - cos_t) / (n * cos_i + cos_t)
    return np.where(sin_t2 >= 1, 1.0, 0.5 * (s**2 + p**2))


def midpoints(a, b, count):
    return a + (np.arange(count) + 0.5) * (b - a) / count


def ball_transmitted(n):
    """Share of parallel light on a ball that goes in and straight out: the integral of (1 - F)^2 2 b db."""
    b = np.sqrt(midpoints(0, 1, 200000))
    return float(np.mean((1 - fresnel(np.sqrt(1 - b**2), n))**2))


def slab(n, half_angle=0.0, internal=True):
    """Transmittance of a slab, with or without its internal reflections, averaged over a uniform disk of light."""
    sin2 = midpoints(0, np.sin(half_angle)**2, 20000) if half_angle else np.zeros(1)
    f = fresnel(np.sqrt(1 - sin2), n)
    return float(np.mean((1 - f) / (1 + f) if internal else (1 - f)**2))


def ball_rays(n, b):
    """Unit ball, light from +z: exit point (r, z), direction (r, z) and transmittance of rays at height b."""
    t, u = np.arcsin(b), np.arcsin(b / n)
    turn = 2 * (t - u)
    # The entry point turns by pi - 2u about the centre on the way through.
    angle = t + np.pi - 2 * u
    return np.sin(angle), np.cos(angle), -np.sin(turn), -np.cos(turn), (1 - fresnel(np.sqrt(1 - b**2), n))**2


def ball_landing(n, b, depth):
    """Signed radius at which rays of height b meet the plane z = -depth, and their transmittance; NaN where they do
    not."""
    r, z, dr, dz, share = ball_rays(n, b)
    with np.errstate(divide="ignore", invalid="ignore"):
        t = (-depth - z) / dz
    return np.where((dz < 0) & (t >= 0), r + t * dr, np.nan), share


def ball_irradiance(n, depth, edges, samples=20000, turns=256):
    """Mean irradiance in the cells of a square grid on the plane z = -depth, per irradiance of the parallel light. It is
    E(r) = sum T b / (r |dr/db|), integrated over each cell by mapping equal parts of the light forward."""
    b = np.sqrt(midpoints(0, 1, samples))
    r, share = ball_landing(n, b, depth)
    reach = np.abs(edges).max() * np.sqrt(2)
    keep = ~np.isnan(r) & (np.abs(r) < reach)
    # The golden angle spreads the azimuths of neighbouring heights.
    phi = 2 * np.pi * (np.arange(turns)[None, :] / turns + 0.618033988749895 * np.arange(samples)[keep][:, None] / turns)
    x, y = r[keep][:, None] * np.cos(phi), r[keep][:, None] * np.sin(phi)
    weight = np.broadcast_to(share[keep][:, None] * np.pi / (samples * turns), x.shape)
    flux, _, _ = np.histogram2d(y.ravel(), x.ravel(), bins=(edges, edges), weights=weight.ravel())
    return flux / np.outer(np.diff(edges), np.diff(edges))


def ball_rings(n, depth, radii, inside=range(30), samples=1000000):
    """Mean irradiance in rings of the plane z = -depth below a ball of radius 1, per irradiance of the parallel light from
    straight above: what the ball mirrors outside, and what leaves it after each number of reflections inside. Directions
    and places are polar angles from the top, in the plane of the ray."""
    b = np.sqrt(midpoints(0, 1, samples))
    i, r = np.arcsin(b), np.arcsin(b / n)
    mirrored = fresnel(np.sqrt(1 - b**2), n)
    paths = [(i, 2 * i, mirrored)]
    for k in inside:
        paths.append((i + (k + 1) * (np.pi - 2 * r), np.pi + 2 * (i - r) + k * (np.pi - 2 * r), (1 - mirrored) ** 2 * mirrored**k))
    flux = np.zeros(len(radii) - 1)
    for place, way, share in paths:
        down = -np.cos(way)
        with np.errstate(divide="ignore"):
            along = (depth + np.cos(place)) / down
        lands = np.abs(np.sin(place) + along * np.sin(way))
        flux += np.histogram(lands[down > 0], bins=radii, weights=share[down > 0])[0] * np.pi / samples
    return flux / (np.pi * np.diff(np.square(radii)))


def nephroid(t):
    """Envelope of light along +x in a mirror circle of radius 1, reflected at (cos t, sin t)."""
    return np.cos(t) - 0.5 * np.cos(t) * np.cos(2 * t), np.sin(t) - 0.5 * np.cos(t) * np.sin(2 * t)


def nephroid_irradiance(height, x_edges, y_edges, samples=3000):
    """Irradiance on the floor of a mirror cylinder of radius 1 and that height under a sun at 45 degrees along +x, per
    irradiance on the floor, by forward mapping: a ray at lateral distance b that meets the wall at height z lands z
    behind the reflection; the near rim shades the wall below height - chord. First reflections only."""
    b = midpoints(-1, 1, 2 * samples)[:, None]
    s = midpoints(0, height, samples)[None, :]
    t = np.arcsin(b)
    chord = 2 * np.cos(t)
    lit = (s > height - chord) & (s < chord)
    x, y = np.cos(t) - s * np.cos(2 * t), np.sin(t) - s * np.sin(2 * t)
    weight = np.where(lit, (2 / (2 * samples)) * (height / samples), 0)
    flux, _, _ = np.histogram2d(y.ravel(), x.ravel(), bins=(y_edges, x_edges),
                                weights=np.broadcast_to(weight, x.shape).ravel())
    return flux / np.outer(np.diff(y_edges), np.diff(x_edges))


def rectangle_solid_angle(x0, x1, y0, y1, h):
    """Of a rectangle at distance h below the point (0, 0)."""
    def corner(a, b):
        return np.arctan(a * b / (h * np.sqrt(a * a + b * b + h * h)))
    return float(corner(x1, y1) - corner(x0, y1) - corner(x1, y0) + corner(x0, y0))


def mirror_room(half, height, lamp, x, y, reach=200):
    """Irradiance per watt on the black floor |x|, |y| < half of a room with mirror walls and a mirror ceiling, from a
    point lamp, without the direct light: the lamp's images in the walls and, all again, in the ceiling."""
    e = np.zeros(np.broadcast(x, y).shape)
    k = np.arange(-reach, reach + 1)
    xs = np.where(k % 2 == 0, lamp[0], -lamp[0]) + 2 * half * k
    ys = np.where(k % 2 == 0, lamp[1], -lamp[1]) + 2 * half * k
    for h in (lamp[2], 2 * height - lamp[2]):
        for image_x in xs:
            d2 = (x[..., None] - image_x)**2 + (y[..., None] - ys)**2 + h * h
            e += (h / d2**1.5).sum(axis=-1)
        # What lies outside the square of images: the integral of h / r^3 outside a square of half side a.
        a = (2 * reach + 1) * half
        e += h * 4 * np.sqrt(2) / a / (2 * half)**2
    direct = lamp[2] / ((x - lamp[0])**2 + (y - lamp[1])**2 + lamp[2]**2)**1.5
    return (e - direct) / (4 * np.pi)


def mirror_room_cut(half, height, bounces):
    """What `mirror_room` loses, anywhere on the floor, when paths end after that many reflections: all images outside the
    diamond |x| + |y| = 2 half bounces, so far away that their sum is the integral of h / r^3, which is 8 h / diagonal."""
    return 2 * height * 8 / (2 * half * bounces) / (2 * half)**2 / (4 * np.pi)
