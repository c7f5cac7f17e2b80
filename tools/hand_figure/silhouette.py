# SPDX-License-Identifier: MIT
"""Silhouettes of a mesh and of a figure from a camera, and rays along the mesh's outline."""
import cv2
import numpy as np

import figure

FOCAL_PX, SIZE_PX = 1400.0, 1100
SHIFT = 4


class View:
    """A pinhole camera at `distance_mm` from `target`, in the unit `direction` from it."""

    def __init__(self, direction, distance_mm, target):
        z = -np.asarray(direction, float)
        x = np.cross([0, -1.0, 0], z) if abs(z[1]) < 0.95 else np.array([1.0, 0, 0])
        x /= np.linalg.norm(x)
        y = np.cross(z, x)
        self.R = np.stack([x, y, z])
        self.eye = target - z * distance_mm
        self.focal = FOCAL_PX * distance_mm / 400

    def project(self, points):
        p = (points - self.eye) @ self.R.T
        return p[:, :2] / p[:, 2:] * self.focal + SIZE_PX / 2, p[:, 2]

    def rays(self, pixels):
        d = np.column_stack([(pixels - SIZE_PX / 2) / self.focal, np.ones(len(pixels))]) @ self.R
        return d / np.linalg.norm(d, axis=1, keepdims=True)


def views(rng, count, target):
    """Alternately of the palm and of the back, within 60 degrees, evenly over the sphere; 0.3 to 0.6 m away."""
    out = []
    for i in range(count):
        c = rng.uniform(0.5, 1)
        a = rng.uniform(0, 2 * np.pi)
        s = np.sqrt(1 - c * c)
        direction = [s * np.cos(a), s * np.sin(a), c * (1 if i % 2 == 0 else -1)]
        out.append(View(direction, rng.uniform(300, 600), target))
    return out


def fill(view, points, polygons, image, value):
    q, depth = view.project(points)
    q = np.round(np.clip(q, -3000, 5000) * (1 << SHIFT)).astype(np.int32)
    for polygon in q[polygons[depth[polygons].min(1) > 30]]:
        cv2.fillConvexPoly(image, polygon, value, shift=SHIFT)


def mesh_mask(view, hand, skin=None):
    """255 hand, 128 forearm, as in the rendered truth."""
    skin = hand.skin_mm if skin is None else skin
    is_hand = skin[hand.quads][:, :, 1].mean(1) >= hand.wrist_mm
    mask = np.zeros((SIZE_PX, SIZE_PX), np.uint8)
    fill(view, skin, hand.quads[~is_hand], mask, 128)
    fill(view, skin, hand.quads[is_hand], mask, 255)
    return mask


def outline_pixels(mask, wrist_margin_px=8):
    """Outline of hand and forearm together, where it is the hand's and away from where hand and forearm meet."""
    contours, _ = cv2.findContours((mask > 0).astype(np.uint8), cv2.RETR_CCOMP, cv2.CHAIN_APPROX_NONE)
    c = np.concatenate([k[:, 0] for k in contours if len(k) > 20])
    forearm = cv2.dilate((mask == 128).astype(np.uint8), np.ones((2 * wrist_margin_px + 1,) * 2, np.uint8))
    inside = (c.min(1) > 2) & (c.max(1) < SIZE_PX - 3)
    c = c[inside]
    return c[forearm[c[:, 1], c[:, 0]] == 0]


def outline_rays(view_list, hand, per_view, skin=None):
    """Eyes and directions of rays along the outline of the mesh in all views."""
    eyes, directions = [], []
    for v in view_list:
        c = outline_pixels(mesh_mask(v, hand, skin))
        c = c[np.linspace(0, len(c) - 1, min(per_view, len(c))).astype(int)].astype(float)
        directions.append(v.rays(c))
        eyes.append(np.tile(v.eye, (len(c), 1)))
    return np.concatenate(eyes), np.concatenate(directions)


def figure_mask(view, centres, radii):
    """Silhouette of the figure: each hull is seen as the hull of its spheres' outlines."""
    mask = np.zeros((SIZE_PX, SIZE_PX), np.uint8)
    rims = [_rim(view, c, r) for c, r in zip(centres, radii)]
    for hull in figure.HULLS:
        points = np.concatenate([rims[i] for i in hull if i >= 0])
        polygon = cv2.convexHull(points.astype(np.float32))[:, 0]
        cv2.fillConvexPoly(mask, np.round(polygon * (1 << SHIFT)).astype(np.int32), 255, shift=SHIFT)
    return mask


def _rim(view, centre, radius, count=48):
    """Where rays touch a sphere: a circle nearer than its centre, smaller than the sphere."""
    to = centre - view.eye
    d2 = to @ to
    e = figure.ray_frames((to / np.sqrt(d2))[None])[0]
    a = np.linspace(0, 2 * np.pi, count, endpoint=False)
    k = radius * np.sqrt(1 - radius**2 / d2)
    rim = view.eye + to * (1 - radius**2 / d2) + k * (np.cos(a)[:, None] * e[0] + np.sin(a)[:, None] * e[1])
    return view.project(rim)[0]
