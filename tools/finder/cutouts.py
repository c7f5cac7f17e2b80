# SPDX-License-Identifier: MIT
"""Renders training hands and people, each one another person in another light, as cut-outs.

  blender -b -t 1 -P cutouts.py -- RENDER_FOLDER --kind open|closed|people --first 1 --count 1000 --out DIR

Writes DIR/KIND/000001.png (colours and alpha) and DIR/KIND/000001.json: fingertips and roots of the
fingers in pixels and which face of the hand is seen, or where a person's face is. The same number gives the same picture. Blender is started once, so that a
picture takes about a second; numbers that are there are skipped. Hands whose fingertips cannot all be
seen are left out.
"""
import argparse
import functools
import json
import os
import sys

import numpy as np

sys.path[:0] = [os.path.dirname(os.path.abspath(__file__))]  # which Blender leaves out
from cutout_hands import Hands
from cutout_people import People
from cutout_studio import Studio


class Body:
    """MakeHuman's base mesh; what mhhand.py reads anew for each hand is read once."""

    def __init__(self, mhhand):
        self.mhhand = mhhand
        whole = mhhand.load_obj()
        mhhand.load_obj = lambda: (whole[0].copy(), *whole[1:])

        @functools.lru_cache(None)
        def shifts(name):
            rows = [l.split() for l in open(os.path.join(mhhand.MH, 'targets', name + '.target')) if l[0] != '#']
            rows = [x for x in rows if len(x) == 4]
            return np.array([int(x[0]) for x in rows]), np.array([[float(v) for v in x[1:]] for x in rows])

        def target(V, name, w):
            at, by = shifts(name)
            V[at] += w * by
        mhhand.target = target
        load, files = json.load, {}

        def load_once(file):
            if file.name not in files:
                files[file.name] = load(file)
            return files[file.name]
        mhhand.json.load = load_once
        self.vertices, self.uv, self.faces, self.face_uv, self.groups = whole
        self.skeleton = mhhand.json.load(open(os.path.join(mhhand.MH, 'default.mhskel')))
        self.weights = mhhand.json.load(open(os.path.join(mhhand.MH, 'default_weights.mhw')))['weights']


def main():
    ap = argparse.ArgumentParser()
    ap.add_argument('render')
    ap.add_argument('--kind', required=True, choices=['open', 'closed', 'people'])
    ap.add_argument('--first', type=int, default=1)
    ap.add_argument('--count', type=int, required=True)
    ap.add_argument('--out', required=True)
    a = ap.parse_args(sys.argv[sys.argv.index('--') + 1:])
    sys.path[:0] = [os.path.join(a.render, 'tools')]
    import mhhand
    body, studio = Body(mhhand), Studio(a.render)
    maker = People(body, studio, a.render) if a.kind == 'people' else Hands(body, studio, a.render, a.kind == 'closed')
    folder = os.path.join(os.path.abspath(a.out), a.kind)
    os.makedirs(folder, exist_ok=True)
    for number in range(a.first, a.first + a.count):
        path = os.path.join(folder, '%06d' % number)
        if os.path.exists(path + '.json'):
            continue
        # Numbers of kinds do not meet, nor those of mkrandom.py.
        r = np.random.default_rng([number, ['open', 'closed', 'people'].index(a.kind), 20261126])
        told = maker.take(path + '.png', r)
        if told is not None:
            with open(path + '.json', 'w') as file:
                json.dump(told, file)


if __name__ == '__main__':
    main()
