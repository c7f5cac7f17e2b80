# SPDX-License-Identifier: MIT
"""Specs of tabletops that a hand sets up: it lies there, goes, and the camera orbits, looks away four times and comes back.

  tabletops.py RENDER/tools FIRST LAST --out OUT/specs

Writes OUT/specs/tabletop_001.json ...; the same seed gives the same spec: another hand, skin, table, room, clutter and motion.
"""
import argparse
import json
import os
import sys

import numpy as np

TABLES = ['wood', 'pine', 'grey', 'dark', 'white', 'blue']
ROOMS = ['st_fagans_interior_1k.hdr', 'lebombo_1k.hdr', 'brown_photostudio_02_1k.hdr', 'aerodynamics_workshop_1k.hdr']
THINGS = [dict(t='mug', s=[0.042, 0.092]), dict(t='kbd', s=[0.4, 0.13]), dict(t='book', s=[0.16, 0.23, 0.03]),
          dict(t='box', s=[0.12, 0.08, 0.06], noise=0.2), dict(t='img', s=[0.21, 0.297]), dict(t='img', s=[0.21, 0.297]),
          dict(t='pen'), dict(t='box', s=[0.075, 0.15, 0.009], r=0.1)]


def clutter(rng):
    """Three to seven things round the hand, none on another."""
    placed = []
    for which in rng.permutation(len(THINGS))[:rng.integers(3, 8)]:
        thing = dict(THINGS[which])
        size = thing.get('s', [0.15, 0.02])
        radius = 0.5 * np.hypot(size[0], size[1]) if thing['t'] != 'mug' else size[0]
        for _ in range(200):
            at = rng.uniform([-0.45, -0.25], [0.45, 0.5])
            off_hand = np.hypot(at[0], at[1] + 0.02) > 0.14 + radius and not (abs(at[0]) < 0.1 + radius and at[1] < 0)
            if off_hand and all(np.linalg.norm(at - other) > radius + r for other, r in [p[:2] for p in placed]):
                break
        else:
            continue
        thing.update(p=[round(float(at[0]), 3), round(float(at[1]), 3), 0.0006 if thing['t'] == 'img' else 0],
                     rz=round(float(rng.uniform(-1.5, 1.5)), 2), c=[round(float(c), 2) for c in rng.uniform(0.05, 0.85, 3)])
        if thing['t'] == 'img':
            thing['img'] = f'assets/gen/paper{rng.integers(6)}.jpg'
        if thing['t'] == 'book':
            thing['img'] = f'assets/gen/poster{rng.integers(6)}.jpg'
        placed.append((at, radius, thing))
    return [thing for _, _, thing in placed]


def away(rng):
    """Four times of at least a second in which the camera sees no table."""
    starts = 4.2 + 2.2 * np.arange(4) + rng.uniform(0, 0.5, 4)
    return [[round(float(s), 2), round(float(s + rng.uniform(1.1, 1.3)), 2)] for s in starts]


def spec(seed, mkrandom):
    rng = np.random.default_rng(90000 + seed)
    u = lambda a, b: round(float(rng.uniform(a, b)), 3)
    hand = dict(mkrandom.SKINS[int(rng.integers(len(mkrandom.SKINS)))], side='LR'[int(rng.integers(2))],
                params=mkrandom.hand_shape(rng), sleeve=dict(color=[u(0.1, 0.7) for _ in range(3)], start=u(0.05, 0.08)))
    lamp = dict(W=u(7, 10), size=0.8, pos=[u(-0.9, 0.9), u(0.3, 0.8), 1.1], at=[0, 0.1, 0], color=[1, 0.96, 0.9])
    return dict(kind='world', frames=390, seed=1000 + seed, cam=dict(fx=618.0, shift=[-0.0045, -0.004]), hand=hand,
                light=dict(hdri='assets/hdri/' + ROOMS[int(rng.integers(len(ROOMS)))], rot=u(0, 360), strength=u(0.7, 1.1), clamp=15,
                           areas=[lamp]),
                table=dict(type='img', img=f'assets/gen/table_{TABLES[seed % len(TABLES)]}.jpg', x=0, y=0.15),
                hand_on_table=[u(-0.04, 0.04), u(-0.03, 0.03), u(-0.1, 0.1)], clutter=clutter(rng),
                render=dict(spp=6, bounces=1, thr=0.03, minspp=4, bake=48),
                traj=dict(gone=[1.8, 2.5], move=1.2, away=away(rng), target=[u(-0.02, 0.02), u(0.02, 0.06), 0], d=u(0.52, 0.62),
                          dr=u(0.06, 0.1), el0=u(30, 38), elr=u(10, 15), azr=u(40, 60)),
                name=f'tabletop/{seed:03d}')


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('render_tools', help='RENDER/tools, for mkrandom.py')
    parser.add_argument('first', type=int)
    parser.add_argument('last', type=int)
    parser.add_argument('--out', required=True)
    args = parser.parse_args()
    sys.path.insert(0, args.render_tools)
    import mkrandom
    os.makedirs(args.out, exist_ok=True)
    for seed in range(args.first, args.last + 1):
        with open(f'{args.out}/tabletop_{seed:03d}.json', 'w') as file:
            json.dump(spec(seed, mkrandom), file, indent=1)


if __name__ == '__main__':
    main()
