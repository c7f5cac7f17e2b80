#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""How far rendered hands' figures are from real ones: real_hands.py FIGURE.json LIST.json [--pictures DIR]

LIST.json: a list of photographs with one open hand each, fields `image`, `face` (palm or back), `thumb`
(right or left: where it is in the picture with the fingers up), the five `tips` in pixels, `mask` (hand
white; none where skin before a plain light wall can be told by its colour), `wrist`: how many spans
below the middle fingertip the hand's own outline ends. Pose, finger angles and modes are fitted to the
outline; then residual deviations of centres and radii are sought that make all outlines most likely.
"""
import argparse
import json

import cv2
import numpy as np

import articulate
import figure

ABDUCTION_SIGMA, FLEXION_SIGMA = np.radians(5.0), np.radians(8.0)
FOCAL_WIDTHS = 1.2
# Annotations are good to a percent of the width; neighbouring points of an outline share their errors.
TIP_SIGMA_MM, OUTLINE_WEIGHT = 3.0, 0.25


def hand_mask(item, image):
    if item.get('mask'):
        return (cv2.imread(item['mask'], 0) > 127).astype(np.uint8)
    lab = cv2.cvtColor(image, cv2.COLOR_BGR2Lab).astype(np.float32)
    colour = cv2.GaussianBlur(lab[..., 1] + 0.5 * lab[..., 2], (0, 0), 2)
    colour = np.uint8(255 * (colour - colour.min()) / np.ptp(colour))
    return (cv2.threshold(colour, 0, 255, cv2.THRESH_OTSU)[1] > 0).astype(np.uint8)


class Photograph:
    """Rays along a hand's outline in a camera frame in which the hand looks like thumb_right."""

    def __init__(self, item):
        image = cv2.imread(item['image'])
        scale = 800 / max(image.shape[:2])
        self.image = cv2.resize(image, None, fx=scale, fy=scale, interpolation=cv2.INTER_CUBIC)
        mask = hand_mask(item, self.image)
        mask = cv2.resize(mask * 255, self.image.shape[1::-1], interpolation=cv2.INTER_CUBIC)
        mask = (cv2.GaussianBlur(mask, (0, 0), 1.5) > 127).astype(np.uint8)
        tips = (np.array(item['tips']) + 0.5) * scale - 0.5
        self.width = self.image.shape[1]
        if item['thumb'] == 'left':
            self.image, mask = self.image[:, ::-1].copy(), mask[:, ::-1].copy()
            tips[:, 0] = self.width - 1 - tips[:, 0]
        self.mirror = np.array([1, 1, -1.0, 1]) if item['face'] == 'back' else np.ones(4)
        self.tips, self.centre = tips, (np.array(self.image.shape[1::-1]) - 1) / 2
        self.focal = FOCAL_WIDTHS * max(self.image.shape[:2])
        self.pixels = self._outline(mask, item.get('wrist', 1.0))
        d = np.column_stack([(self.pixels - self.centre) / self.focal, np.ones(len(self.pixels))])
        self.frames = figure.ray_frames(d / np.linalg.norm(d, axis=1, keepdims=True))

    def _outline(self, mask, wrist):
        contours, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
        c = max(contours, key=cv2.contourArea)[:, 0].astype(float)
        up = self.tips[2] - 0.5 * (self.tips[0] + self.tips[4])
        up /= np.linalg.norm(up)
        span = np.linalg.norm(self.tips[0] - self.tips[4])
        h, w = mask.shape
        c = c[(c.min(1) > 4) & (c[:, 0] < w - 5) & (c[:, 1] < h - 5)]
        c = c[(self.tips[2] - c) @ up < wrist * span]
        return c[:: max(1, len(c) // 240)]


def rotation(vector):
    angle = np.linalg.norm(vector)
    return np.eye(3) if angle == 0 else articulate.turn(vector / angle, angle)


class Fit:
    """Parameters: rotation vector, translation (mm), abductions, root flexions, middle flexions, coefficients."""

    def __init__(self, photo, figure_data):
        self.photo = photo
        self.mean = 1000 * np.array(figure_data['mean'])
        self.modes = 1000 * np.array(figure_data['modes'])
        angles = [ABDUCTION_SIGMA] * 5 + [FLEXION_SIGMA] * 10
        self.sigma = np.concatenate([[1e3] * 6, angles, np.ones(len(self.modes))])
        self.R = np.diag([1.0, -1, -1])
        self.p = np.zeros(len(self.sigma))
        self._start()

    def _start(self):
        """From the tips: the similarity in the picture that lays the mean's tips on the annotated ones."""
        a = self.mean[108:].reshape(5, 3)[:, :2] * [1, -1]
        b = self.photo.tips - self.photo.centre
        za, zb = (v[:, 0] + 1j * v[:, 1] for v in (a - a.mean(0), b - b.mean(0)))
        k = (zb * za.conj()).sum() / (za * za.conj()).sum().real
        angle = np.angle(k)
        self.R = articulate.turn(np.array([0, 0, 1.0]), angle) @ self.R
        z = self.photo.focal / abs(k)
        self.start_mm = z
        c = b.mean(0) * z / self.photo.focal
        self.p[3:6] = np.append(c, z) - self.R @ np.append(a.mean(0) * [1, -1], 0)

    def placed(self, p):
        """Spheres and tips in the camera frame."""
        v = self.mean + p[21:] @ self.modes
        x, tips = v[:108].reshape(27, 4), v[108:].reshape(5, 3)
        x, tips = articulate.articulated(x, p[6:11], p[11:16], p[16:21], tips=tips)
        x, tips = x * self.photo.mirror, tips * self.photo.mirror[:3]
        R = rotation(p[:3]) @ self.R
        return np.column_stack([x[:, :3] @ R.T + p[3:6], x[:, 3]]), tips @ R.T + p[3:6]

    def _tip_errors(self, tips):
        """In the picture, as millimetres at the distance of the start."""
        seen = tips[:, :2] / tips[:, 2:] * self.photo.focal + self.photo.centre
        return ((seen - self.photo.tips) * self.start_mm / self.photo.focal).ravel()

    def linearised(self):
        """Outline distances, their derivatives by the parameters and by single spheres in the hand frame;
        errors of the tips and their derivatives."""
        y, tips = self.placed(self.p)
        eyes = np.zeros((len(self.photo.frames), 3))
        near = figure.distance_to_rays(eyes, self.photo.frames, y[:, :3], y[:, 3])
        J = figure.jacobian(near)
        chain, tip_chain = np.empty((108, len(self.p))), np.empty((10, len(self.p)))
        for i in range(len(self.p)):
            h = 1e-4 if i < 3 or 6 <= i < 21 else 1e-2
            q = self.p.copy()
            q[i] += h
            y_moved, tips_moved = self.placed(q)
            chain[:, i] = ((y_moved - y) / h).ravel()
            tip_chain[:, i] = (self._tip_errors(tips_moved) - self._tip_errors(tips)) / h
        J4 = J.reshape(-1, 27, 4)
        own = np.concatenate([J4[..., :3] @ self.R, J4[..., 3:]], 2) * self.photo.mirror
        # At the distance of the start: nearer hands would otherwise have lesser errors.
        k = self.start_mm / self.p[5]
        by_parameters = k * (J @ chain)
        by_parameters[:, 5] -= k * near['value'] / self.p[5]
        return k * near['value'], by_parameters, k * own.reshape(len(J), 108), self._tip_errors(tips), tip_chain

    def run(self, steps=40):
        """The pose first, then fingers and shape as well. The annotated tips keep fingers from slipping
        along themselves."""
        for k in range(steps):
            e, J, _, t, T = self.linearised()
            free = 0.05 if k < 8 else 0.4 if k < 16 else 1.0
            prior = 1 / np.where(np.arange(len(self.p)) < 6, self.sigma, free * self.sigma)**2
            w = OUTLINE_WEIGHT / (1 + (e / (12.0 if k < 16 else 4.0))**2)
            v = 1 / (TIP_SIGMA_MM**2 * (1 + (t / (3 * TIP_SIGMA_MM))**2))
            A = (J * w[:, None]).T @ J + (T * v[:, None]).T @ T + np.diag(prior)
            gradient = J.T @ (w * e) + T.T @ (v * t) + np.where(np.arange(len(self.p)) < 6, 0, prior * self.p)
            limit = np.where(np.arange(len(self.p)) // 3 == 1, 40, np.where(np.arange(len(self.p)) < 21, 0.1, 0.4))
            self.p -= np.clip(np.linalg.solve(A, gradient), -limit, limit)
            self.R = rotation(self.p[:3]) @ self.R
            self.p[:3] = 0
        return self.linearised()[:3]


CHOICES_MM = (0.1, 0.3, 0.5, 0.7, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0)


def entry_sigma(doubt):
    s = np.zeros((27, 4))
    for name, spheres in figure.GROUPS.items():
        s[spheres] = [doubt[name], doubt[name], doubt['depth'], doubt[name + ' radius']]
    return s.ravel()


def log_likelihood(outline, doubt):
    """Of an outline, linear around the fit: parameters and spheres' own deviations integrated out."""
    e, J, own, p, sigma = outline
    use = np.abs(e) < 10
    e, J, own = e[use], J[use], own[use]
    y = e - J @ np.where(np.arange(len(p)) < 6, 0, p)
    C = (J * sigma**2) @ J.T + (own * entry_sigma(doubt)**2) @ own.T + doubt['noise']**2 * np.eye(len(e))
    L = np.linalg.cholesky(C)
    z = np.linalg.solve(L, y)
    return -0.5 * z @ z - np.log(np.diag(L)).sum() - 0.5 * len(e) * np.log(2 * np.pi)


def most_likely_doubt(outlines, rounds=3):
    """One deviation after the other set to the most likely of CHOICES_MM."""
    doubt = dict(noise=1.0, depth=2.0, **{g: 3.0 for g in figure.GROUPS},
                 **{g + ' radius': 1.0 for g in figure.GROUPS})

    def scores(name):
        return {c: sum(log_likelihood(o, {**doubt, name: c}) for o in outlines) for c in CHOICES_MM}

    for _ in range(rounds):
        for name in doubt:
            score = scores(name)
            doubt[name] = max(score, key=score.get)
        print('most likely (%.1f): %s' %
              (max(score.values()), ', '.join('%s %.1f' % d for d in doubt.items())), flush=True)
    for name in doubt:
        score = scores(name)
        near = [c for c, v in score.items() if v > max(score.values()) - 2]
        print('  %-16s within 2 of the best: %s mm' % (name, ' '.join('%.1f' % c for c in near)))
    return doubt


def picture(fit, path):
    image, y = fit.photo.image.copy(), fit.placed(fit.p)[0]
    mask = np.zeros(image.shape[:2], np.uint8)
    project = lambda q: q[:, :2] / q[:, 2:] * fit.photo.focal + fit.photo.centre
    a = np.linspace(0, 2 * np.pi, 40)
    rims = [project(c + r * np.column_stack([np.cos(a), np.sin(a), 0 * a])) for c, r in zip(y[:, :3], y[:, 3])]
    for hull in figure.HULLS:
        polygon = cv2.convexHull(np.concatenate([rims[i] for i in hull if i >= 0]).astype(np.float32))
        cv2.fillConvexPoly(mask, np.round(polygon).astype(np.int32), 255)
    outline, _ = cv2.findContours(mask, cv2.RETR_LIST, cv2.CHAIN_APPROX_NONE)
    cv2.drawContours(image, outline, -1, (0, 0, 255), 2)
    for q in fit.photo.pixels:
        cv2.circle(image, (int(q[0]), int(q[1])), 2, (0, 255, 0), -1)
    cv2.imwrite(path, image)


def main():
    ap = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    ap.add_argument('figure')
    ap.add_argument('list')
    ap.add_argument('--pictures')
    a = ap.parse_args()
    data = json.load(open(a.figure))
    found, coefficients = [], []
    for i, item in enumerate(json.load(open(a.list))):
        fit = Fit(Photograph(item), data)
        e, J, own = fit.run()
        found.append((e, J, own, fit.p, fit.sigma))
        coefficients.append(fit.p[21:])
        print('%-24s outline rms %.2f mm, median %.2f; abduction %s; coefficients %s' % (
            item['image'].split('/')[-1], np.sqrt(np.mean(np.minimum(e**2, 144))), np.median(np.abs(e)),
            np.degrees(fit.p[6:11]).round(1), fit.p[21:27].round(1)), flush=True)
        if a.pictures:
            picture(fit, '%s/%02d.jpg' % (a.pictures, i))
    print('coefficients: mean', np.mean(coefficients, 0).round(2))
    print('  standard deviation', np.std(coefficients, 0).round(2))
    most_likely_doubt(found)


if __name__ == '__main__':
    main()
