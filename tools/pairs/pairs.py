# SPDX-License-Identifier: MIT
"""Specs of pairs of sequences that show one random hand.

  pairs.py FOLDER_OF_MKRANDOM FIRST LAST --out specs

Of every stiff palm among the random sequences FIRST to LAST: that sequence, to calibrate from, and
another in which the back of the same hand is shown, with living fingers, in another room.
"""
import argparse
import copy
import json
import os
import sys

KINDS = 3  # of seeds: stiff hands, living ones, webcams
FRAMES = 60


def main():
    ap = argparse.ArgumentParser()
    ap.add_argument('mkrandom')
    ap.add_argument('first', type=int)
    ap.add_argument('last', type=int)
    ap.add_argument('--out', required=True)
    a = ap.parse_args()
    sys.path.insert(0, a.mkrandom)
    import mkrandom
    for seed in range(a.first, a.last + 1):
        stiff = mkrandom.spec(seed, FRAMES)
        if seed % KINDS or stiff['traj'].get('face') != 'palm':
            continue
        others = (mkrandom.spec(k, FRAMES) for k in range(1000 + seed, 1100 + seed) if k % KINDS == 1)
        alive = copy.deepcopy(next(s for s in others if s['traj'].get('face') == 'back' and s.get('room') != stiff.get('room')))
        alive['hand'] = stiff['hand']
        for name, spec in (('stiff', stiff), ('alive', alive)):
            spec['name'] = 'pairs/%04d/%s' % (seed, name)
            with open(os.path.join(a.out, '%s_%04d.json' % (name, seed)), 'w') as file:
                json.dump(spec, file, indent=1)


if __name__ == '__main__':
    main()
