# SPDX-License-Identifier: MIT
"""Hands for cutouts.py: their postures, forearms and sleeves, in the frame of mhhand.py, millimetres."""
import bpy
import numpy as np
from mathutils import Vector

from cutout_studio import SIDE, Material, mesh_object, move_vertices, subdivided, turned

FINGERS = '12345'
# Where the thumb of a hand that shows four fingers lies (fingers.py).
FOUR_AZ, FOUR_EL = (30, -22, -48), (48, 30, 14)


def posture(params, kind, r):
    """Directions of the fingers' segments (azimuth, elevation), and how far each is folded."""
    spread = {'spread': r.uniform(0.7, 1.25), 'easy': r.uniform(0.2, 0.9), 'together': r.uniform(-0.05, 0.3)}
    way = r.choice(['spread', 'easy', 'together', 'relaxed'], p=[0.18, 0.24, 0.34, 0.24])
    s = spread.get(way, r.uniform(0, 0.8))
    az = {f: [s * v for v in params['az'][f]] for f in '2345'}
    thumb = r.uniform(-38, 12)
    az['1'] = [v + thumb * w for v, w in zip(params['az']['1'], (1, 0.9, 0.8))]
    together = r.normal(0, 5) if r.random() < 0.5 else abs(r.normal(0, 14))  # all fingers bend together
    el = {}
    for f in '2345':
        root, middle, end = together + r.normal(0, 4), abs(r.normal(0, 8)), abs(r.normal(0, 4))
        el[f] = [root, root + middle, root + middle + end]
        apart = r.normal(0, 6 if f == '5' else 2)  # little fingers stand off more than others do
        az[f] = [v + apart + r.normal(0, 2.5) for v in az[f]]
    el['1'] = [v + r.normal(6, 9) for v in (10, 4, 2)]
    if way == 'relaxed':
        bent = r.uniform(0, 24)
        for f in '2345':
            el[f] = np.cumsum([bent * r.uniform(0, 1), bent + r.uniform(0, 8), 0.6 * bent]).tolist()
        el['1'] = [v + r.uniform(0, 35) for v in (10, 4, 2)]
    fold = dict.fromkeys(FINGERS, 0.0)
    if kind == 'closed':
        four = r.random() < 0.5
        if four or r.random() < 0.5:  # the thumb before the palm
            w = r.uniform(0.75, 1.1)
            az['1'] = [a + (b - a) * w for a, b in zip(az['1'], FOUR_AZ)]
            el['1'] = [a + (b - a) * w for a, b in zip(el['1'], FOUR_EL)]
        if not four:
            for f in r.permutation(list('2345'))[:r.integers(1, 5)]:
                fold[f] = r.uniform(0.7, 1.0)
            if r.random() < 0.3:  # a fist
                fold = {f: r.uniform(0.85, 1.0) for f in FINGERS}
    return az, el, fold


class Hands:
    def __init__(self, body, studio, render, closed):
        import mkrandom
        self.body, self.studio, self.render, self.kind, self.shape = body, studio, render, 'closed' if closed else 'open', mkrandom.hand_shape
        self.skin, self.cloth = Material('skin', True), Material('cloth', False)
        hand = self.hand(mkrandom.hand_shape(np.random.default_rng(0)))
        vertices, faces, uv = self.with_forearm(hand, hand.V0)
        self.thing = subdivided(mesh_object('hand', vertices * 0.001, faces, uv, self.skin.material), 1)
        # Fingertips are places of the skin, told where all fingers are apart.
        smooth, self.tips = self.smooth(), []
        for f in FINGERS:
            head, tail = hand.head['finger%s-3.R' % f] * 0.001, hand.tail['finger%s-3.R' % f] * 0.001
            length = np.linalg.norm(tail - head)
            way, off = (tail - head) / length, smooth - head
            along = off @ way
            near = np.nonzero((np.linalg.norm(off - np.outer(along, way), axis=1) < 0.013) & (along > 0.3 * length) & (along < 2.5 * length))[0]
            self.tips.append(near[np.argmax(along[near])])
        self.sleeve = mesh_object('sleeve', np.zeros((32 * 12, 3)), [(i * 32 + k, i * 32 + (k + 1) % 32, (i + 1) * 32 + (k + 1) % 32, (i + 1) * 32 + k)
                                                                     for i in range(11) for k in range(32)], None, self.cloth.material)
        self.sleeve.parent = self.thing

    def hand(self, params):
        return self.body.mhhand.Hand(dict(params, level=False))

    def with_forearm(self, hand, posed):
        """The hand's mesh, its forearm longer; faces are made the first time."""
        if not hasattr(self, 'border'):
            edges = {}
            for f, t in zip(hand.F, hand.FT):
                for i in range(len(f)):
                    a, b = f[i], f[(i + 1) % len(f)]
                    if edges.pop((b, a), None) is None:
                        edges[a, b] = (t[i], t[(i + 1) % len(f)])
            self.border = sorted({a for a, _ in edges})
            order = {v: i for i, v in enumerate(self.border)}
            n, m = len(hand.V0), len(self.border)
            ring = lambda v, j: v if j < 0 else n + j * m + order[v]
            self.faces = [list(f) for f in hand.F] + [[ring(b, j - 1), ring(a, j - 1), ring(a, j), ring(b, j)] for j in range(3) for a, b in edges]
            self.face_uv = [[tuple(hand.T[t]) for t in f] for f in hand.FT] + [[tuple(hand.T[v]), tuple(hand.T[u]), tuple(hand.T[u]), tuple(hand.T[v])]
                                                                             for _ in range(3) for u, v in edges.values()]
        rest = hand.V0[self.border]
        middle, low = rest.mean(0), rest[:, 1].min()
        rings = [np.column_stack([middle[0] + (rest[:, 0] - middle[0]) * k, np.full(len(rest), low - far), middle[2] + (rest[:, 2] - middle[2]) * k])
                 for far, k in ((60, 1.05), (250, 1.15), (500, 1.25))]
        return np.vstack([posed, *rings]), self.faces, self.face_uv

    def smooth(self):
        graph = bpy.context.evaluated_depsgraph_get()
        graph.update()
        evaluated = self.thing.evaluated_get(graph)
        mesh = evaluated.to_mesh()
        v = np.empty(len(mesh.vertices) * 3, np.float32)
        mesh.vertices.foreach_get('co', v)
        evaluated.to_mesh_clear()
        return v.reshape(-1, 3).astype(float)

    def dress(self, hand, vertices, r):
        self.sleeve.hide_render = r.random() > 0.45
        self.cloth.cloth(r)
        wrist = hand.head['wrist.R'][1]
        first, wide = wrist - (r.uniform(-5, 30) if r.random() < 0.5 else r.uniform(30, 160)), r.uniform(2, 12)
        angles = 2 * np.pi * np.arange(32) / 32
        rows = []
        for i, y in enumerate(first - np.array([-0.5, 0, 2, 8, 25, 60, 100, 160, 230, 320, 430, 560])):
            arm = vertices[np.argsort(np.abs(vertices[:, 1] - min(max(y, vertices[:, 1].min()), wrist)))[:14]]
            middle, radius = arm.mean(0), np.ptp(arm, axis=0) / 2
            grow = wide * (0.4 if i == 0 else 1 + 0.002 * (first - y)) + r.normal(0, 1, 32) * (i > 3)
            rows.append(np.column_stack([middle[0] + (radius[0] * 1.05 + grow) * np.cos(angles), np.full(32, y), middle[2] + (radius[2] * 1.05 + grow) * np.sin(angles)]))
        move_vertices(self.sleeve, np.vstack(rows) * 0.001)

    def take(self, path, r):
        hand = self.hand(self.shape(r))
        az, el, fold = posture(hand.P, self.kind, r)
        posed, heads, _ = hand.pose(az=az, el=el, fold=fold)
        vertices = self.with_forearm(hand, posed)[0]
        move_vertices(self.thing, vertices * 0.001)
        self.skin.skin(self.render, r)
        self.dress(hand, vertices, r)
        tips = self.smooth()[self.tips]
        # Palm or back to the camera, tilted to any side; a left hand is the mirror image.
        away = r.random() < 0.5
        tilt, to = abs(r.normal(0, 30)) if r.random() < 0.85 else r.uniform(0, 70), r.uniform(0, 2 * np.pi)
        R = turned(np.radians(tilt) * np.cos(to), np.radians(tilt) * np.sin(to), np.radians(r.normal(0, 20))) @ turned(0, np.pi if away else 0, 0)
        R = np.diag([-1.0 if r.random() < 0.5 else 1.0, 1, 1]) @ R
        distance = np.exp(r.uniform(np.log(0.2), np.log(0.9)))
        at = np.array([0, 0.03, -distance]) - R @ [0, 0.02, 0]
        self.studio.place([self.thing], R, at, r.uniform(720, 880) * distance)
        self.studio.light(r, at)
        bpy.context.view_layer.update()
        placed = tips @ R.T + at
        pixels = self.studio.project(placed)
        if self.kind == 'open' and not (self.visible(placed) and (pixels > 2).all() and (pixels < SIDE - 3).all()):
            return None
        if not self.studio.shoot(path, r):
            return None
        if self.kind != 'open':
            return dict(shows='back' if away else 'palm')
        roots = 0.001 * np.array([heads['finger%s-1.R' % f] for f in FINGERS]) @ R.T + at
        return dict(tips=pixels.round(2).tolist(), roots=self.studio.project(roots).round(2).tolist(), shows='back' if away else 'palm')

    def visible(self, placed):
        graph = bpy.context.evaluated_depsgraph_get()
        for p in placed:
            hit, where, *_ = bpy.context.scene.ray_cast(graph, Vector((0, 0, 0)), Vector(p).normalized(), distance=float(np.linalg.norm(p)))
            if hit and where.length < np.linalg.norm(p) - 0.012:
                return False
        return True
