# SPDX-License-Identifier: MIT
"""Specs of training hands: a renderer's random hands in the postures that its own seeds lack.

  postures.py FOLDER_OF_MKRANDOM FIRST LAST --out specs [--frames 24] [--together | --relaxed | --closed]

Fingers close or wide apart (--together: side by side, as most people hold them; --relaxed: bent at
all joints, the thumb beside the palm and before it, as one waves), the thumb along the palm or far
from it, fingers bent, palms tilted by up to 65 degrees. --closed: fists and, every second, hands
with the thumb folded in, which the finder learns to leave alone. Seeds up to 100 and above 1000 are
others' (building, reporting, kept aside).
"""
import argparse
import json
import os
import sys

import numpy as np


def relax(spec, r):
    """Bends every finger at its three joints; the thumb comes forward and along the index finger."""
    params = spec['hand']['params']
    spread = r.uniform(0, 0.8)
    for finger, rest in (('2', 15), ('4', -13), ('5', -30)):
        params['az'][finger] = [round(spread * rest, 1)] * 3
    params['az']['1'] = [round(v - r.uniform(5, 40), 1) for v in (46, 50, 56)]
    bent = r.uniform(0, 22)
    params['el'] = {f: np.cumsum([bent * r.uniform(0, 1), bent + r.uniform(0, 8), 0.6 * bent]).round(1).tolist() for f in '2345'}
    params['el']['1'] = [round(v + r.uniform(0, 35), 1) for v in (10, 4, 2)]
    params['level'] = False  # lies on no table
    spec['live'].update(flex=[3, 12], min_gap=-1.0)


def main():
    ap = argparse.ArgumentParser()
    ap.add_argument('mkrandom')
    ap.add_argument('first', type=int)
    ap.add_argument('last', type=int)
    ap.add_argument('--frames', type=int, default=24)
    ap.add_argument('--together', action='store_true')
    ap.add_argument('--relaxed', action='store_true')
    ap.add_argument('--closed', action='store_true')
    ap.add_argument('--out', required=True)
    a = ap.parse_args()
    sys.path.insert(0, a.mkrandom)
    import mkrandom
    for seed in range(a.first, a.last + 1):
        r = np.random.default_rng(90000 + seed)
        spec = mkrandom.spec(3 * seed + 1, a.frames)  # living fingers, an ideal camera
        spread = r.uniform(0.25, 1.3) if r.random() < 0.8 else 1.0
        if a.together:
            spread = r.uniform(-0.05, 0.4)
        az = spec['hand']['params']['az']
        for finger in '245':
            az[finger] = [round(spread * v, 1) for v in az[finger]]
        thumb = r.uniform(-32, 12)
        az['1'] = [round(v + thumb * w, 1) for v, w in zip(az['1'], (1, 0.9, 0.8))]
        spec['live'] = dict(abd=[1, 5], flex=[3, 22], freq=[0.5, 1.2], tremor=0.25, min_gap=-1.0 if a.together else 2.0)
        if a.relaxed:
            relax(spec, r)
        if a.closed:
            spec['live']['events'] = [['four' if seed % 2 else 'fist', -1.0, 60.0]]
        spec['traj'].update(tilt=round(r.uniform(15, 65), 1), roll=round(r.uniform(10, 60), 1), freq=[0.6, 1.5])
        spec['render'].update(spp=8, mblur=0)
        spec.update(kind='inspect', name='postures/%04d' % seed)
        with open(os.path.join(a.out, 'postures_%04d.json' % seed), 'w') as file:
            json.dump(spec, file, indent=1)


if __name__ == '__main__':
    main()
