# SPDX-License-Identifier: MIT
"""People for cutouts.py: heads and shoulders."""
import numpy as np

from cutout_studio import SIDE, Material, mesh_object, move_vertices, subdivided, turned

# Colours of hair, linear: black, browns, blond, grey, red.
HAIR = [(0.008, 0.007, 0.007), (0.02, 0.012, 0.008), (0.06, 0.03, 0.015), (0.35, 0.22, 0.1), (0.25, 0.25, 0.25), (0.15, 0.04, 0.015)]


class People:
    """Heads and shoulders, dressed and mostly with hair; the arms hang and have no hands in view."""

    def __init__(self, body, studio, render):
        self.body, self.studio, self.render = body, studio, render
        self.skin, self.cloth, self.hair, self.eye = (Material(n, n == 'skin') for n in ('skin', 'cloth', 'hair', 'eye'))
        self.parts = {}
        # Hair hangs to the waist and before the face: it is cut there, and at the shoulders or the ears.
        neck = self.joint(body.vertices, 'head')
        before = lambda c: c[2] > 0.6 and abs(c[0]) < 0.85 and c[1] < 1.0
        for name, groups, material, keep in (
                ('body', ['body'], self.skin, None), ('shirt', ['helper-tights'], self.cloth, None), ('eyes', ['helper-l-eye', 'helper-r-eye'], self.eye, None),
                ('long hair', ['helper-hair'], self.hair, lambda c: not before(c)),
                ('hair', ['helper-hair'], self.hair, lambda c: not before(c) and c[1] > -1.8),
                ('short hair', ['helper-hair'], self.hair, lambda c: not before(c) and c[1] > 0.1)):
            faces = [i for i, g in enumerate(body.groups) if g in groups and (keep is None or keep(body.vertices[body.faces[i]].mean(0) - neck))]
            used = sorted({v for i in faces for v in body.faces[i]})
            order = {v: i for i, v in enumerate(used)}
            thing = mesh_object(name, body.vertices[used], [[order[v] for v in body.faces[i]] for i in faces],
                                [[tuple(body.uv[t]) for t in body.face_uv[i]] for i in faces], material.material)
            self.parts[name] = (subdivided(thing, 1), used)
        arms, names = np.zeros((2, len(body.vertices))), body.skeleton['bones']
        for bone in names:
            chain, b = [], bone
            while b:
                chain.append(b)
                b = names[b]['parent']
            for side, of in (('L', 0), ('R', 1)):
                if 'upperarm01.' + side in chain:
                    for v, w in body.weights.get(bone, []):
                        arms[of, v] += w
        self.arms = np.minimum(arms, 1)

    def joint(self, vertices, bone):
        return vertices[self.body.skeleton['joints'][self.body.skeleton['bones'][bone]['head']]].mean(0)

    def take(self, path, r):
        v = self.body.vertices.copy()
        for name, w in zip(('caucasian-male-young', 'african-female-young', 'asian-male-young'), r.dirichlet([0.7] * 3)):
            self.body.mhhand.target(v, name, w)
        v *= 0.1  # decimetres
        for side, of in (('L', 0), ('R', 1)):
            shoulder = self.joint(v, 'upperarm01.' + side)
            down = r.uniform(15, 55) if r.random() < 0.9 else -r.uniform(0, 20)
            R = turned(0, 0, np.radians(-down if side == 'L' else down))
            w = self.arms[of][:, None]
            v = v + w * ((v - shoulder) @ R.T + shoulder - v)
        head = self.joint(v, 'head')
        v = (v - head) @ np.diag([r.uniform(0.93, 1.07), r.uniform(0.93, 1.07), r.uniform(0.93, 1.07)])
        for thing, used in self.parts.values():
            move_vertices(thing, v[used])
        self.skin.skin(self.render, r)
        self.cloth.cloth(r)
        self.hair.cloth(r, dark=True)
        base = np.array(HAIR[r.integers(len(HAIR))]) * np.exp(r.normal(0, 0.3))
        self.hair.mix.inputs['Color1'].default_value, self.hair.mix.inputs['Color2'].default_value = (*base, 1), (*(0.5 * base), 1)
        self.eye.cloth(r, dark=True)
        worn = ['long hair', 'hair', 'short hair', None][r.choice(4, p=[0.25, 0.2, 0.4, 0.15])]
        for name in ('long hair', 'hair', 'short hair'):
            self.parts[name][0].hide_render = name != worn
        self.parts['shirt'][0].hide_render = r.random() < 0.08
        distance = np.exp(r.uniform(np.log(0.5), np.log(1.5)))
        R = turned(np.radians(r.normal(0, 10)), np.radians(np.clip(r.normal(0, 25), -70, 70)), np.radians(r.normal(0, 6)))
        at = np.array([0, 0.1, -distance])
        self.studio.place([thing for thing, _ in self.parts.values()], R, at, SIDE / 0.62 * distance)
        self.studio.light(r, at)
        if not self.studio.shoot(path, r):
            return None
        return dict(face=self.studio.project(R @ [0, 0.03, 0.1] + at).round(1).tolist())
