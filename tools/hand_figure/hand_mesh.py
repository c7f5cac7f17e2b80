# SPDX-License-Identifier: MIT
"""Rendered hands as posed meshes in the hand frame, in millimetres.

A hand is the right hand seen from the palm (layout thumb_right): x to the thumb, y along the middle
finger, z out of the palm. The skin is the limit of Catmull-Clark subdivision, as the renderer shows it.
"""
import functools
import os
import sys

import numpy as np
from scipy import sparse

FINGERS = '12345'


def use_render_folder(path):
    """Makes the renderer's modules importable; its files are read once and kept."""
    sys.path[:0] = [path, os.path.join(path, 'tools')]
    import mhhand
    mhhand.load_obj = functools.lru_cache(None)(mhhand.load_obj)
    loaded = mhhand.load_obj

    def fresh_copy():
        V, *rest = loaded()
        return (V.copy(), *rest)

    mhhand.load_obj = fresh_copy
    mhhand.target = _cached_target(mhhand.MH)


def _cached_target(folder):
    @functools.lru_cache(None)
    def offsets(name):
        rows = [l.split() for l in open(os.path.join(folder, 'targets', name + '.target')) if l[0] != '#']
        rows = [r for r in rows if len(r) == 4]
        return np.array([int(r[0]) for r in rows]), np.array([[float(x) for x in r[1:]] for r in rows])

    def target(V, name, weight):
        if weight:
            index, offset = offsets(name)
            np.add.at(V, index, weight * offset)

    return target


def subdivision(vertex_count, faces):
    """One Catmull-Clark step: the matrix from old vertices to new, and the new quads."""
    edges = {}
    for f, face in enumerate(faces):
        for a, b in zip(face, face[1:] + face[:1]):
            edges.setdefault((min(a, b), max(a, b)), []).append(f)
    edge_id = {e: i for i, e in enumerate(edges)}
    nv, ne, nf = vertex_count, len(edges), len(faces)
    F = sparse.lil_matrix((nf, nv))
    for f, face in enumerate(faces):
        F[f, face] = 1.0 / len(face)
    F = F.tocsr()
    inner = np.array([len(s) == 2 for s in edges.values()])
    ends = np.array(list(edges))
    M = sparse.csr_matrix((np.full(2 * ne, 0.5), (np.repeat(np.arange(ne), 2), ends.ravel())), (ne, nv))
    sides = sparse.lil_matrix((ne, nf))
    for i, s in enumerate(edges.values()):
        if len(s) == 2:
            sides[i, s] = 0.25
    keep = sparse.diags(np.where(inner, 0.5, 1.0))
    E = keep @ M + sides.tocsr() @ F
    V = _vertex_rule(nv, faces, edges, F, M)
    quads = []
    for f, face in enumerate(faces):
        n = len(face)
        for i, v in enumerate(face):
            after = edge_id[tuple(sorted((v, face[(i + 1) % n])))]
            before = edge_id[tuple(sorted((face[i - 1], v)))]
            quads.append([v, nv + after, nv + ne + f, nv + before])
    return sparse.vstack([V, E, F]).tocsr(), quads


def _rings(nv, faces, edges):
    """Which faces and edges touch each vertex, as 0-1 matrices, and which vertices lie on the border."""
    corners = np.concatenate(faces)
    face_of = np.repeat(np.arange(len(faces)), [len(f) for f in faces])
    touch_f = sparse.csr_matrix((np.ones(len(corners)), (corners, face_of)), (nv, len(faces)))
    ends = np.array(list(edges))
    edge_of = np.repeat(np.arange(len(ends)), 2)
    touch_e = sparse.csr_matrix((np.ones(2 * len(ends)), (ends.ravel(), edge_of)), (nv, len(ends)))
    border = np.zeros(nv, bool)
    border[ends[[len(s) == 1 for s in edges.values()]].ravel()] = True
    return touch_f, touch_e, border


def _vertex_rule(nv, faces, edges, F, M):
    touch_f, touch_e, border = _rings(nv, faces, edges)
    n = np.maximum(np.asarray(touch_e.sum(1)).ravel(), 1)
    inner = sparse.diags(np.where(border, 0.0, 1.0))
    D = lambda x: sparse.diags(x)
    rule = D(1 / n**2) @ touch_f @ F + D(2 / n**2) @ touch_e @ M + D((n - 3) / n)
    return inner @ rule + D(border.astype(float))


def limit_projection(nv, quads):
    """Moves each vertex of a quad mesh to the limit surface (border vertices stay)."""
    edges = {}
    for f, q in enumerate(quads):
        for a, b in zip(q, q[1:] + q[:1]):
            edges.setdefault((min(a, b), max(a, b)), []).append(f)
    touch_f, touch_e, border = _rings(nv, quads, edges)
    n = np.asarray(touch_e.sum(1)).ravel()
    ends = np.array(list(edges))
    both_ways = np.r_[ends[:, 0], ends[:, 1]], np.r_[ends[:, 1], ends[:, 0]]
    neighbours = sparse.csr_matrix((np.ones(2 * len(ends)), both_ways), (nv, nv))
    q = np.array(quads)
    corners = np.repeat(np.arange(len(q)), 4), q.ravel()
    around = touch_f @ sparse.csr_matrix((np.ones(q.size), corners), (len(q), nv))
    # A face's four corners are the vertex, two neighbours and the opposite corner, which weighs 1 as
    # against 4 of a neighbour and n squared of the vertex.
    opposite = around - sparse.diags(n) - 2 * neighbours
    rule = sparse.diags(1 / (n * (n + 5))) @ (sparse.diags(n**2) + 4 * neighbours + opposite)
    inner = sparse.diags(np.where(border, 0.0, 1.0))
    return (inner @ rule + sparse.diags(border.astype(float))).tocsr()


class Skin:
    """Matrices from the coarse mesh (with the forearm made longer) to its limit surface."""

    def __init__(self, hand):
        faces = [list(f) for f in hand.F]
        self.border, faces = _longer_forearm(hand, faces)
        nv = len(hand.V0) + 3 * len(self.border)
        S1, q1 = subdivision(nv, faces)
        S2, q2 = subdivision(S1.shape[0], q1)
        self.coarse = (limit_projection(S1.shape[0], q1) @ S1).tocsr()
        self.coarse_quads = np.array(q1)
        self.fine = (limit_projection(S2.shape[0], q2) @ S2 @ S1).tocsr()

    def extended(self, rest, posed):
        p = rest[self.border]
        c, y_min = p.mean(0), p[:, 1].min()
        rings = []
        for dy, k in ((60, 1.05), (250, 1.15), (600, 1.25)):
            ring = c + (p - c) * k
            ring[:, 1] = y_min - dy
            rings.append(ring)
        return np.vstack([posed] + rings)


def _longer_forearm(hand, faces):
    count = {}
    for f in faces:
        for a, b in zip(f, f[1:] + f[:1]):
            count.setdefault((min(a, b), max(a, b)), []).append((a, b))
    open_edges = [s[0] for s in count.values() if len(s) == 1]
    border = sorted({v for e in open_edges for v in e})
    place = {v: i for i, v in enumerate(border)}
    nv, nb = len(hand.V0), len(border)
    out = list(faces)
    ring = lambda v, j: v if j < 0 else nv + j * nb + place[v]
    for j in range(3):
        out += [[ring(b, j - 1), ring(a, j - 1), ring(a, j), ring(b, j)] for a, b in open_edges]
    return np.array(border), out


class MeshHand:
    """One person's hand: `skin_mm` of the limit surface, `joints_mm` of the bones, `tips_mm`, and
    `wrist_mm`, the y of the crease."""
    skin = None

    def __init__(self, params):
        import mhhand
        self.hand = mhhand.Hand(params)
        if MeshHand.skin is None:
            MeshHand.skin = Skin(self.hand)
        posed, heads, tails = self.hand.pose()
        fine = self._limit(MeshHand.skin.fine, posed)
        self.tip_ids = [self._tip_id(fine, heads, tails, f) for f in FINGERS]
        tips = fine[self.tip_ids]
        self.origin = np.array([tips[2, 0], tips[0, 1], tips[:, 2].mean()])
        self.tips_mm = tips - self.origin
        self.wrist_mm = self.hand.head['wrist.R'][1] - self.origin[1] - 4
        self.skin_mm = self._limit(MeshHand.skin.coarse, posed) - self.origin
        self.joints_mm = self._joints(heads)
        self.quads = MeshHand.skin.coarse_quads

    def _limit(self, matrix, posed):
        return matrix @ MeshHand.skin.extended(self.hand.V0, posed)

    def _joints(self, heads):
        return np.array([[heads['finger%s-%d.R' % (f, k)] - self.origin for k in (1, 2, 3)] for f in FINGERS])

    @staticmethod
    def _tip_id(v, heads, tails, f):
        h, t = heads['finger%s-3.R' % f], tails['finger%s-3.R' % f]
        L = np.linalg.norm(t - h)
        d = (t - h) / L
        r = v - h
        s = r @ d
        off_axis = np.linalg.norm(r - np.outer(s, d), axis=1)
        near = np.where((off_axis < 13) & (s > 0.3 * L) & (s < 2.5 * L))[0]
        return int(near[np.argmax(s[near])])

    def posed(self, az, el):
        """Skin, joints and tips with other finger angles, in the same hand frame."""
        posed, heads, _ = self.hand.pose(az=az, el=el)
        tips = self._limit(MeshHand.skin.fine, posed)[self.tip_ids] - self.origin
        return self._limit(MeshHand.skin.coarse, posed) - self.origin, self._joints(heads), tips
