# SPDX-License-Identifier: Apache-2.0
"""What rough facets reflect in all, as Blender counts it and as the renderer does (Heitz 2014; Kulla and Conty 2017).

Light that meets another facet is lost to GGX. Multiscatter GGX, the default from 4.0 on, gives it back, tinted by how often it
was reflected. What leaves at once is less in the renderer and in Blender 3.4, where shadowing does not know of masking."""
import functools

SAMPLES = 48  # squared, of the normals
MEANS = 32    # directions of a mean over the hemisphere


def lobe(cos, alpha):
    """Over the normals visible from a direction: (cosines to them, shares that leave with joint shadowing, with separate)."""
    import numpy as np
    u, v = (x.ravel() for x in np.meshgrid(*[(np.arange(SAMPLES) + 0.5) / SAMPLES] * 2))
    eye = np.array([(1 - cos * cos) ** 0.5, 0, cos])
    tall = eye * (alpha, alpha, 1)
    tall /= np.linalg.norm(tall)
    side = np.array([0.0, 1, 0])  # the eye lies in the plane of x and z
    up = np.cross(tall, side)
    radius, phi, lean = np.sqrt(u), 2 * np.pi * v, 0.5 * (1 + tall[2])
    x, y = radius * np.cos(phi), radius * np.sin(phi)
    y = (1 - lean) * np.sqrt(np.maximum(0, 1 - x * x)) + lean * y
    half = x[:, None] * side + y[:, None] * up + np.sqrt(np.maximum(0, 1 - x * x - y * y))[:, None] * tall
    half = half * (alpha, alpha, 1)
    half /= np.linalg.norm(half, axis=1, keepdims=True)
    c = half @ eye
    out = 2 * c * half[:, 2] - cos  # cosine of what is reflected
    masked, shadowed = (0.5 * (np.sqrt(1 + alpha * alpha * (1 - z * z) / np.maximum(z * z, 1e-12)) - 1) for z in (cos, out))
    up = out > 0
    return np.clip(c, 0, 1), np.where(up, (1 + masked) / (1 + masked + shadowed), 0), np.where(up, 1 / (1 + shadowed), 0)


def alpha_of(roughness):
    return max(roughness * roughness, 1e-4)


@functools.lru_cache(maxsize=256)
def mirror(roughness):
    """Of facets that reflect all: (joint, separate), what leaves at once in the mean over the hemisphere."""
    import numpy as np
    cosines = (np.arange(MEANS) + 0.5) / MEANS
    found = np.array([[x.mean() for x in lobe(c, alpha_of(roughness))[1:]] for c in cosines])
    return tuple(float(x) for x in 2 * (found * cosines[:, None]).mean(axis=0))


def bounced(fresnel, leaves):
    """What is left of light that was reflected more than once, where facets reflect `fresnel` of it in the mean."""
    return fresnel * leaves / (1 - fresnel * (1 - leaves))


def gain(roughness, color, multiscatter, joint):
    """What a metal's color in Blender is times for the renderer to reflect as much in the mean over the hemisphere."""
    of_joint, separate = mirror(roughness)
    leaves = of_joint if joint else separate
    return (leaves + (bounced(color, leaves) * (1 - leaves) if multiscatter else 0)) / separate
