#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Silhouettes of figures against those of meshes that the statistics have not seen.

  validate.py RENDER_FOLDER FIGURE.json HELD_OUT_FITS.npz [--hands 24] [--views 60] [--picture F.png]
"""
import argparse
import json

import cv2
import numpy as np

import figure
import fit
import fit_hands
import hand_mesh
import silhouette

WAYS = ('fitted directly', 'modes only', 'mean, scaled by span', '  and placed rigidly')
MM_PER_PX = 400 / silhouette.FOCAL_PX


def compare(view, hand, x, mask):
    """Intersection over union without and with the wrist, distances (mm) from the mesh's outline to the
    figure's and back; the forearm is left out."""
    own = silhouette.figure_mask(view, x[:, :3], x[:, 3])
    forearm = cv2.dilate((mask == 128).astype(np.uint8), np.ones((17, 17), np.uint8)) > 0
    a, b = (mask == 255) & ~forearm, (own > 0) & ~forearm
    pixels = silhouette.outline_pixels(mask).astype(float)
    directions = view.rays(pixels)
    eyes = np.tile(view.eye, (len(pixels), 1))
    there = figure.distance_to_rays(eyes, figure.ray_frames(directions), x[:, :3], x[:, 3])['value']
    contours, _ = cv2.findContours((own > 0).astype(np.uint8), cv2.RETR_CCOMP, cv2.CHAIN_APPROX_NONE)
    c = np.concatenate([k[:, 0] for k in contours])
    c = c[(c.min(1) >= 0) & (c.max(1) < silhouette.SIZE_PX)]
    c = c[~forearm[c[:, 1], c[:, 0]]]
    distance = sum(cv2.distanceTransform(np.uint8(side), cv2.DIST_L2, 5) for side in (mask == 0, mask > 0))
    back = (distance[c[:, 1], c[:, 0]] - 0.5) * MM_PER_PX
    whole = ((mask == 255) & (own > 0)).sum() / ((mask == 255) | ((own > 0) & (mask != 128))).sum()
    return (a & b).sum() / (a | b).sum(), whole, there, back


def rigidly_placed(x, onto):
    """The same figure turned and moved so that its centres come closest to another's."""
    a, b = x[:, :3] - x[:, :3].mean(0), onto[:, :3] - onto[:, :3].mean(0)
    U, _, Vt = np.linalg.svd(a.T @ b)
    R = U @ np.diag([1, 1, np.linalg.det(U @ Vt)]) @ Vt
    return np.column_stack([a @ R + onto[:, :3].mean(0), x[:, 3]])


def overlay(view, hand, x):
    mask = silhouette.mesh_mask(view, hand)
    own = silhouette.figure_mask(view, x[:, :3], x[:, 3])
    image = np.stack([mask, (mask == 255) * own, own], -1)
    return image[100:1000:2, 100:1000:2]


def summary(name, results):
    iou = np.array([r[0] for r in results])
    there, back = np.concatenate([r[2] for r in results]), np.concatenate([r[3] for r in results])
    size = lambda v: 'mean size %.2f, 95 %% %.2f, rms %.2f mm' % (
        np.abs(v).mean(), np.percentile(np.abs(v), 95), np.sqrt(np.mean(v**2)))
    print('%-22s IoU %.4f (least %.4f, with wrist %.4f); mesh to figure: mean %+.2f, %s; back: %s' %
          (name, iou.mean(), iou.min(), np.mean([r[1] for r in results]), there.mean(), size(there),
           size(back)), flush=True)


def main():
    ap = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    ap.add_argument('render_folder')
    ap.add_argument('figure')
    ap.add_argument('fits')
    ap.add_argument('--hands', type=int, default=24)
    ap.add_argument('--views', type=int, default=60)
    ap.add_argument('--picture')
    a = ap.parse_args()
    hand_mesh.use_render_folder(a.render_folder)
    data, fits = json.load(open(a.figure)), np.load(a.fits)
    mean, modes = 1000 * np.array(data['mean']), 1000 * np.array(data['modes'])
    rng = np.random.default_rng(77)
    results, pictures, tip_errors = {}, [], []
    for i, shape in enumerate(json.loads(str(fits['shapes']))[:a.hands]):
        hand = hand_mesh.MeshHand(shape)
        by_modes, p = fit.fit_coefficients(hand, mean, modes, silhouette.views(rng, 24, fit_hands.LOOK_AT_MM))
        tips = (mean + p @ modes)[108:].reshape(5, 3)
        tip_errors.append(np.linalg.norm(tips - hand.tips_mm, axis=1))
        span = lambda t: np.linalg.norm(t[0] - t[4])
        scaled = mean[:108].reshape(27, 4) * span(hand.tips_mm) / span(mean[108:].reshape(5, 3))
        view_list = silhouette.views(rng, a.views, fit_hands.LOOK_AT_MM)
        masks = [silhouette.mesh_mask(v, hand) for v in view_list]
        fitted = fits['spheres'][i]
        figures = dict(zip(WAYS, (fitted, by_modes, scaled, rigidly_placed(scaled, fitted))))
        for name, x in figures.items():
            for k, v in enumerate(view_list):
                results.setdefault((name, ('palm', 'back')[k % 2]), []).append(compare(v, hand, x, masks[k]))
            if i < 4:
                pictures.append(np.hstack([overlay(v, hand, x) for v in view_list[:4]]))
    for name in WAYS:
        summary(name, results[name, 'palm'] + results[name, 'back'])
        for face in ('palm', 'back'):
            summary('  ' + face, results[name, face])
    print('tips by modes only: rms %.2f mm' % np.sqrt(np.mean(np.array(tip_errors)**2)))
    if a.picture:
        cv2.imwrite(a.picture, np.vstack(pictures))


if __name__ == '__main__':
    main()
