#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""How well turned spheres follow the rendered fingers.

  articulate.py RENDER_FOLDER FITS.npz [--hands 6] [--poses 6]

Fingers abduct and bend as the renderer's living hands do. The fitted figure is turned by the known
angles about pivots that are tried one after the other; the outline of the posed mesh, seen by rays,
says how far the figure is off.
"""
import argparse
import json

import numpy as np

import figure
import fit
import fit_hands
import hand_mesh
import silhouette


def turn(axis, angle):
    K = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    return np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K


def articulated(x, abduction, mcp, pip, pivot=(0, 0), joint_pivot=(0, 0), web_share=0.0, tips=None,
                distal=0.0):
    """Spheres (27 x 4) with fingers turned, radians.

    Abduction (to the thumb, about -z) and flexion (about the axis across the finger in the palm
    plane) at sphere 0, flexion again at sphere 1, and its share `distal` at sphere 2. Pivots are
    moved along the finger and out of the palm, in mm.
    """
    out, moved = x.copy(), None if tips is None else tips.copy()
    for f in range(5):
        s = 4 * f
        along = x[s + 3, :3] - x[s, :3]
        along = along * [1, 1, 0] / np.hypot(*along[:2])
        across = np.cross(along, [0, 0, 1.0])
        first = x[s, :3] + pivot[0] * along + [0, 0, pivot[1]]
        second = x[s + 1, :3] + joint_pivot[0] * along + [0, 0, joint_pivot[1]]
        third = x[s + 2, :3] + [0, 0, joint_pivot[1]]
        R = turn(np.array([0, 0, -1.0]), abduction[f]) @ turn(across, mcp[f])
        P, D = turn(across, pip[f]), turn(across, distal * pip[f])
        chain = [lambda p: p, lambda p: P @ (p - second) + second,
                 lambda p: P @ (D @ (p - third) + third - second) + second]
        for k, bend in ((1, chain[0]), (2, chain[1]), (3, chain[2])):
            out[s + k, :3] = R @ (bend(x[s + k, :3]) - first) + first
        if moved is not None:
            moved[f] = R @ (chain[2](tips[f]) - first) + first
    for k in range(4):
        a = web_share * 0.5 * (abduction[k] + abduction[k + 1])
        pivot_k = 0.5 * (x[4 * k, :3] + x[4 * k + 4, :3])
        out[20 + k, :3] = turn(np.array([0, 0, -1.0]), a) @ (x[20 + k, :3] - pivot_k) + pivot_k
    return out, moved


def random_angles(rng):
    """As rendered living hands: 2 to 6 degrees of abduction, 3 to 10 of flexion; at the middle joint
    half as much, by itself."""
    swing = lambda a, b: rng.uniform(a, b, 5) * np.sin(rng.uniform(0, 2 * np.pi, 5))
    F = rng.uniform(3, 10, 5)
    wave = lambda: np.sin(rng.uniform(0, 2 * np.pi, 5))
    return swing(2, 6), F * wave(), 0.5 * F * wave()


def posed_mesh(hand, abduction, mcp, pip):
    rest, fingers = hand.hand.P, list(enumerate(hand_mesh.FINGERS))
    az = {f: list(np.array(rest['az'][f], float) + abduction[k]) for k, f in fingers}
    bend = lambda k: np.array([mcp[k], mcp[k] + pip[k], mcp[k] + 1.6 * pip[k]])
    el = {f: list(np.array(rest['el'][f], float) + bend(k)) for k, f in fingers}
    return hand.posed(az, el)


class Case:
    """One hand in one posture: rays along the mesh's outline, and the angles."""

    def __init__(self, rng, hand, x, angles):
        skin, _, self.tips = posed_mesh(hand, *angles)
        view_list = silhouette.views(rng, 12, fit_hands.LOOK_AT_MM)
        self.eyes, directions = silhouette.outline_rays(view_list, hand, 300, skin)
        self.frames = figure.ray_frames(directions)
        self.x, self.rest_tips, self.angles = x, hand.tips_mm, np.radians(angles)

    def errors(self, pip_share=None, still=False, **pivots):
        abduction, mcp, pip = self.angles
        if pip_share is not None:
            pip = pip_share * mcp
        if still:
            abduction, mcp, pip = (np.zeros(5),) * 3
        y, tips = articulated(self.x, abduction, mcp, pip, tips=self.rest_tips, **pivots)
        return figure.distance_to_rays(self.eyes, self.frames, y[:, :3], y[:, 3])['value'], tips - self.tips

    def fitted(self, share, distal, steps=6):
        """Five abductions and flexions found from the outline; the middle joint bends `share` again."""
        place = lambda q: articulated(self.x, q[:5], q[5:], share * q[5:], tips=self.rest_tips, distal=distal)
        q = np.zeros(10)
        for _ in range(steps):
            y, tips = place(q)
            near = figure.distance_to_rays(self.eyes, self.frames, y[:, :3], y[:, 3])
            chain = np.stack([(place(q + 1e-4 * u)[0] - y).ravel() / 1e-4 for u in np.eye(10)], 1)
            J = figure.jacobian(near) @ chain
            q = q - np.linalg.solve(J.T @ J + 1e-3 * np.eye(10), J.T @ near['value'])
        y, tips = place(q)
        return figure.distance_to_rays(self.eyes, self.frames, y[:, :3], y[:, 3])['value'], tips - self.tips


def report(name, cases, fitted=None, **how):
    e, t = zip(*[c.fitted(*fitted) if fitted else c.errors(**how) for c in cases])
    e, t = np.concatenate(e), np.array(t)
    print('%-58s outline %.2f mm, tips %.2f mm (in the palm plane %.2f)' %
          (name, np.sqrt(np.mean(e**2)), np.sqrt((t**2).sum(2).mean()),
           np.sqrt((t[..., :2]**2).sum(2).mean())), flush=True)


def main():
    ap = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    ap.add_argument('render_folder')
    ap.add_argument('fits')
    ap.add_argument('--hands', type=int, default=6)
    ap.add_argument('--poses', type=int, default=6)
    a = ap.parse_args()
    hand_mesh.use_render_folder(a.render_folder)
    fits = np.load(a.fits)
    rng = np.random.default_rng(3)
    shapes = json.loads(str(fits['shapes']))[:a.hands]
    hands = [(hand_mesh.MeshHand(s), x) for s, x in zip(shapes, fits['spheres'])]
    rest = [Case(rng, h, x, np.zeros((3, 5))) for h, x in hands]
    cases = [Case(rng, h, x, random_angles(rng)) for h, x in hands for _ in range(a.poses)]
    report('at rest', rest)
    report('posed, figure kept at rest', cases, still=True)
    for along in (-4, 0, 4):
        for out in (-6, -3, 0):
            report('angles known, pivot %+d mm along, %+d out, both joints' % (along, out), cases,
                   pivot=(along, out), joint_pivot=(0, out), distal=0.6)
    report('no distal joint', cases, distal=0.0)
    for share in (0.0, 0.2, 0.4, 0.6):
        report('middle joint %.1f of the root joint' % share, cases, pip_share=share)
    for share in (0.0, 0.2, 0.4, 0.6, 1.0):
        report('ten angles fitted, middle joint %.1f of the root joint' % share, cases, fitted=(share, 0.6))
    for share in (0.5, 1.0):
        report('webs turn by %.1f of their fingers' % share, cases, web_share=share, distal=0.6)


if __name__ == '__main__':
    main()
