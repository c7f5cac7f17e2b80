# SPDX-License-Identifier: MIT
"""The hand figure: spheres and the convex hulls of two or three of them, and its outline as rays see it.

Sphere 4 f + k: finger f from thumb to little, k from the root over the joints to the tip; 20 + k: web
between the fingers k and k + 1; 24 wrist below the thumb, 25 wrist below the little finger, 26
hypothenar. All lengths are millimetres here.
"""
import numpy as np

SPHERES = 27
WEB, WRIST_THUMB, WRIST_LITTLE, HYPOTHENAR = 20, 24, 25, 26
CAPSULES = [(4 * f + k, 4 * f + k + 1) for f in range(5) for k in range(3)]
WEBS = [(0, 1, 20), (0, 20, 4), (4, 21, 8), (8, 22, 12), (12, 23, 16)]
PALM = [(0, 4, 24), (4, 8, 24), (8, 24, 25), (8, 12, 25), (12, 16, 26), (12, 26, 25)]
TRIANGLES = WEBS + PALM
HULLS = [(a, b, -1) for a, b in CAPSULES] + TRIANGLES
EDGES = sorted(set(CAPSULES) | {tuple(sorted((t[i], t[j]))) for t in TRIANGLES
                                for i, j in ((0, 1), (1, 2), (0, 2))})
# Spheres that deviate alike from one person to another.
GROUPS = dict(fingers=[4 * f + k for f in range(5) for k in (1, 2, 3)], knuckles=[4, 8, 12, 16],
              webs=[20, 21, 22, 23], palm=[0, 24, 25, 26])
FINGERS = ('thumb', 'index', 'middle', 'ring', 'little')
NAMES = (['%s_%s' % (f, k) for f in FINGERS for k in ('root', 'joint1', 'joint2', 'tip')]
         + ['web_%d' % k for k in range(4)] + ['wrist_thumb', 'wrist_little', 'hypothenar'])


def distance_to_points(points, centres, radii):
    """Signed distance of points to the union of hulls: value, sphere ids, weights and normal of the nearest place.

    A hull is the union of spheres with affinely varying centre and radius, so its distance is the
    least of |p - c| - r.
    """
    best = _nearest_edge(points[:, None] - centres[None], centres, radii)
    for tri in TRIANGLES:
        _take(best, _nearest_face(points, centres, radii, tri))
    return best


def _nearest_edge(to_spheres, centres, radii):
    """Over all edges; `to_spheres` is (rays, spheres, dimensions), from each sphere to the point or the ray."""
    a, b = np.array(EDGES).T
    pa, pb = to_spheres[:, a], to_spheres[:, b]
    v = pa - pb
    L2 = np.maximum((v * v).sum(-1), 1e-9)
    t = (pa * v).sum(-1) / L2
    h = np.sqrt(np.maximum((pa * pa).sum(-1) - t * t * L2, 0))
    dr = radii[b] - radii[a]
    g = np.clip(dr / np.sqrt(L2), -0.999, 0.999)
    u = np.clip(t + g * h / np.sqrt(L2 * (1 - g * g)), 0, 1)
    near = pa - u[..., None] * v
    length = np.sqrt((near * near).sum(-1))
    value = length - radii[a] - u * dr
    e = value.argmin(1)
    row = np.arange(len(e))
    u, n = u[row, e], near[row, e] / np.maximum(length[row, e], 1e-9)[:, None]
    ids = np.stack([a[e], b[e], a[e]], 1)
    return dict(value=value[row, e], ids=ids, weights=np.stack([1 - u, u, 0 * u], 1), normal=n)


def _take(best, rows_and_other):
    rows, other = rows_and_other
    better = other['value'] < best['value'][rows]
    for k, v in other.items():
        best[k][rows[better]] = v[better]


def _nearest_face(points, centres, radii, tri):
    c, r = centres[list(tri)], radii[list(tri)]
    B = np.stack([c[1] - c[0], c[2] - c[0]], 1)
    G = np.linalg.pinv(B.T @ B)
    n = np.cross(B[:, 0], B[:, 1])
    n /= np.maximum(np.linalg.norm(n), 1e-9)
    slope = B @ G @ (r[1:] - r[0])
    s2 = 1 - slope @ slope
    q = points - c[0]
    h = q @ n
    d = np.abs(h) / np.sqrt(max(s2, 1e-3))
    foot = q - h[:, None] * n + d[:, None] * slope
    w = foot @ B @ G
    # Where the slope is too steep, one sphere holds the others and there is no face.
    rows = np.where((w.min(1) >= 0) & (w.sum(1) <= 1) & (s2 > 1e-3))[0]
    w = np.column_stack([1 - w[rows].sum(1), w[rows]])
    near = points[rows] - w @ c
    length = np.maximum(np.linalg.norm(near, axis=1), 1e-9)
    return rows, dict(value=length - w @ r, ids=np.tile(tri, (len(rows), 1)), weights=w,
                      normal=near / length[:, None])


def ray_frames(directions):
    """Two unit vectors across each unit direction."""
    helper = np.where(np.abs(directions[:, :1]) < 0.7, [[1.0, 0, 0]], [[0, 1.0, 0]])
    e1 = np.cross(directions, helper)
    e1 /= np.linalg.norm(e1, axis=1, keepdims=True)
    return np.stack([e1, np.cross(directions, e1)], 1)


def distance_to_rays(eye, frames, centres, radii):
    """Signed distance from rays through `eye` (rays, 3) to the silhouette of the figure, measured at the hand.

    Seen along a ray, each hull is the flat hull of discs; within it the depth is that below its outline.
    """
    flat = -np.einsum('rij,rsj->rsi', frames, centres[None] - eye[:, None])
    best = _nearest_edge(flat, centres, radii)
    for tri in TRIANGLES:
        _take(best, _depth_in_flat_hull(flat, radii, tri))
    best['normal'] = np.einsum('rij,ri->rj', frames, best['normal'])
    return best


def _depth_in_flat_hull(flat, radii, tri):
    """Rays within the triangle of centres: how deep below the outer tangents of the three discs."""
    p = flat[:, list(tri)]
    r = radii[list(tri)]
    cross = lambda a, b: a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    side = np.stack([cross(p[:, i], p[:, (i + 1) % 3]) for i in range(3)], 1)
    rows = np.where((side.min(1) > 0) | (side.max(1) < 0))[0]
    p = p[rows]
    value = np.full(len(rows), -1e9)
    out = dict(ids=np.tile(tri, (len(rows), 1)), weights=np.zeros((len(rows), 3)), normal=np.zeros((len(rows), 2)))
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        v = p[:, i] - p[:, j]
        L = np.maximum(np.linalg.norm(v, axis=1), 1e-9)
        v /= L[:, None]
        g = (r[j] - r[i]) / L
        root = np.sqrt(np.maximum(1 - g * g, 0))
        for sign in (1, -1):
            n = -g[:, None] * v + sign * root[:, None] * np.stack([-v[:, 1], v[:, 0]], 1)
            depth = (n * p[:, i]).sum(1) - r[i]
            outer = ((n * p[:, k]).sum(1) - r[k] >= depth - 1e-9) & (np.abs(g) < 1)
            better = outer & (depth > value)
            u = np.clip((p[:, i] * v).sum(1) / L + g * ((n * p[:, i]).sum(1)) / L, 0, 1)
            value[better] = depth[better]
            w = np.zeros((len(rows), 3))
            w[:, i], w[:, j] = 1 - u, u
            out['weights'][better], out['normal'][better] = w[better], n[better]
    found = value > -1e8
    return rows[found], dict(value=value[found], **{k: v[found] for k, v in out.items()})


def jacobian(nearest):
    """Of the distances with respect to 27 centres and radii, in the order x, y, z, r of each sphere."""
    n = len(nearest['value'])
    J = np.zeros((n, SPHERES, 4))
    row = np.arange(n)
    for k in range(3):
        w = nearest['weights'][:, k]
        np.add.at(J, (row, nearest['ids'][:, k]), -w[:, None] * np.column_stack([nearest['normal'], np.ones(n)]))
    return J.reshape(n, -1)
