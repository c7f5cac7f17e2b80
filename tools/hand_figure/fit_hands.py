#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Fits the figure to random rendered hands.

  fit_hands.py RENDER_FOLDER COUNT OUT.npz [--seed 1] [--like FITS.npz]

OUT.npz holds, in millimetres and in the hand frame, the spheres (COUNT x 27 x 4), the tips (COUNT x 5
x 3), the outline's rms, and each hand's parameters. With --like the joints' expected offsets are taken
from an earlier run.
"""
import argparse
import json

import numpy as np

import fit
import hand_mesh
import silhouette

LOOK_AT_MM = np.array([10.0, 0.0, -5.0])


def hand_scale(hand):
    return np.linalg.norm(hand.tips_mm[2] - [0, hand.wrist_mm, 0]) / 185


def learn_offset(hands, view_list, rounds=3):
    """How the spheres lie to the bones on average, in hand lengths: the first expectation is only a guess."""
    offset = None
    for _ in range(rounds):
        found = [fit.fit(h, fit.expected_figure(h, offset), view_list)[0] for h in hands]
        offset = np.mean([(x - fit.expected_figure(h)) / hand_scale(h) for x, h in zip(found, hands)], 0)
    return offset


def main():
    ap = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    ap.add_argument('render_folder')
    ap.add_argument('count', type=int)
    ap.add_argument('out')
    ap.add_argument('--seed', type=int, default=1)
    ap.add_argument('--views', type=int, default=32)
    ap.add_argument('--like')
    a = ap.parse_args()
    hand_mesh.use_render_folder(a.render_folder)
    import mkrandom
    rng = np.random.default_rng(a.seed)
    shapes = [mkrandom.hand_shape(rng) for _ in range(a.count)]
    if a.like:
        offset = np.load(a.like)['offset']
    else:
        some = [hand_mesh.MeshHand(s) for s in shapes[:12]]
        offset = learn_offset(some, silhouette.views(rng, 24, LOOK_AT_MM))
    spheres, tips, rms = [], [], []
    for i, s in enumerate(shapes):
        hand = hand_mesh.MeshHand(s)
        view_list = silhouette.views(rng, a.views, LOOK_AT_MM)
        x, e = fit.fit(hand, fit.expected_figure(hand, offset), view_list)
        spheres.append(x)
        tips.append(hand.tips_mm)
        rms.append(e)
        if i % 20 == 19:
            print('%d of %d, outline rms %.2f mm' % (i + 1, a.count, np.mean(rms)), flush=True)
    np.savez(a.out, offset=offset, spheres=spheres, tips=tips, rms=rms, shapes=json.dumps(shapes))


if __name__ == '__main__':
    main()
