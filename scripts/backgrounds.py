# SPDX-License-Identifier: MIT
"""Pictures as what lies behind hands, or where there are none. Needs python3-opencv."""
import os
import cv2
import numpy as np


def pictures(folders):
    for folder in folders:
        for root, _, names in os.walk(folder):
            for name in names:
                if name.lower().endswith((".jpg", ".jpeg", ".png", ".webp", ".ppm", ".pgm")):
                    yield os.path.join(root, name)


def crops(image, width, height, frames, least, rng):
    """A crop of the picture in so many frames, of at least this share of it, that grows and wanders by a twentieth."""
    picture_height, picture_width = image.shape[:2]
    size = rng.uniform(least, 0.95) * min(picture_width / width, picture_height / height)
    room = np.array([picture_width - width * size, picture_height - height * size])
    corner, way = rng.uniform(0, 1, 2) * room, rng.uniform(-0.05, 0.05, 2) * size * width
    for k in range(frames):
        t, scale = k / frames, size * (1 - 0.05 * k / frames)
        x, y = np.clip(corner + t * way, 0, room)
        affine = np.array([[scale, 0, x], [0, scale, y]])
        yield cv2.warpAffine(image, affine, (width, height), flags=cv2.INTER_AREA | cv2.WARP_INVERSE_MAP)
