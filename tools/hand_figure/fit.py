# SPDX-License-Identifier: MIT
"""Lays the figure on one mesh hand: the outline in many views, a little the skin, gently the joints."""
import numpy as np

import figure
import silhouette

RADII_MM = np.array([[17, 12, 9.5, 7.5], [10, 9, 7.5, 6], [10, 9, 7.5, 6], [9.5, 8.5, 7, 5.5],
                     [9, 7.5, 6.5, 5]])
# Doubt of the prior: finger joints, web, wrist and palm; along the outline the picture decides.
JOINT_SIGMA_MM, LOOSE_SIGMA_MM, RADIUS_SIGMA_MM = 2.5, 5.0, 3.0


def expected_figure(hand, offset=None):
    """Spheres at the joints; webs and wrist by proportion. `offset`: what earlier fits found on average,
    for a hand of the base mesh's length."""
    j, tips = hand.joints_mm, hand.tips_mm
    scale = np.linalg.norm(tips[2] - [0, hand.wrist_mm, 0]) / 185
    c, r = np.zeros((figure.SPHERES, 3)), np.full(figure.SPHERES, 8.0 * scale)
    for f in range(5):
        c[4 * f:4 * f + 3] = j[f]
        r[4 * f:4 * f + 4] = RADII_MM[f] * scale
        along = (tips[f] - j[f, 2]) / np.linalg.norm(tips[f] - j[f, 2])
        c[4 * f + 3] = tips[f] - along * r[4 * f + 3]
    for k in range(4):
        low = lambda f: 0.65 * c[4 * f] + 0.35 * c[4 * f + 1]
        a, b = (c[1], c[4]) if k == 0 else (low(k), low(k + 1))
        c[20 + k], r[20 + k] = 0.5 * (a + b), 5.0 * scale
    wrist_z = 0.5 * (j[0, 0, 2] + j[4, 0, 2])
    c[24] = [0.5 * c[4, 0] + 3, hand.wrist_mm + 14, wrist_z]
    c[25] = [0.5 * c[16, 0], hand.wrist_mm + 14, wrist_z]
    c[26] = [c[16, 0], 0.5 * (c[16, 1] + hand.wrist_mm), wrist_z]
    r[24:27] = 13 * scale
    x = np.column_stack([c, r])
    return x if offset is None else x + offset * scale


def prior_sigma():
    s = np.full((figure.SPHERES, 4), JOINT_SIGMA_MM)
    s[20:] = LOOSE_SIGMA_MM
    s[0] = 4.0
    s[:, 3] = RADIUS_SIGMA_MM
    return s


def terms(x, eyes, frames, skin, skin_weight):
    """Normal equations of outline and skin; the residuals of the outline."""
    c, r = x[:, :3], x[:, 3]
    A, b = np.zeros((108, 108)), np.zeros(108)
    outline = None
    for near, weight in ((figure.distance_to_rays(eyes, frames, c, r), 1.0),
                         (figure.distance_to_points(skin, c, r), skin_weight)):
        e = near['value']
        w = weight / len(e) / (1 + (e / 3.0)**2)
        J = figure.jacobian(near)
        A += (J * w[:, None]).T @ J
        b -= J.T @ (w * e)
        outline = e if outline is None else outline
    return A, b, outline


def fit(hand, expected, view_list, per_view=160, steps=14, skin_weight=0.15, prior_weight=2e-3):
    """The figure (27 x 4) and the root mean square of the outline in millimetres."""
    eyes, directions = silhouette.outline_rays(view_list, hand, per_view)
    frames = figure.ray_frames(directions)
    skin = hand.skin_mm[np.unique(hand.quads)]
    skin = skin[skin[:, 1] > hand.wrist_mm + 6][::3]
    x = expected.copy()
    P = prior_weight / prior_sigma()**2
    for _ in range(steps):
        A, b, _ = terms(x, eyes, frames, skin, skin_weight)
        A += np.diag(P.ravel() + 1e-4)
        b -= (P * (x - expected)).ravel()
        step = np.clip(np.linalg.solve(A, b).reshape(-1, 4), -4, 4)
        x = x + step
        x[:, 3] = np.maximum(x[:, 3], 2.5)
    e = terms(x, eyes, frames, skin, skin_weight)[2]
    return x, float(np.sqrt(np.mean(e**2)))


def fit_coefficients(hand, mean, modes, view_list, per_view=160, steps=10, doubt_mm=0.5):
    """Only the modes' coefficients, fitted to the outline; the figure (27 x 4, mm) and the coefficients."""
    eyes, directions = silhouette.outline_rays(view_list, hand, per_view)
    frames = figure.ray_frames(directions)
    p = np.zeros(len(modes))
    for _ in range(steps):
        x = (mean + p @ modes)[:108].reshape(27, 4)
        near = figure.distance_to_rays(eyes, frames, x[:, :3], x[:, 3])
        e = near['value']
        J = figure.jacobian(near) @ modes[:, :108].T
        # Some hundred points of an outline say something of their own.
        w = 300 / len(e) / doubt_mm**2 / (1 + (e / 3.0)**2)
        p = p - np.linalg.solve((J * w[:, None]).T @ J + np.eye(len(p)), J.T @ (w * e) + p)
    return (mean + p @ modes)[:108].reshape(27, 4), p
