# SPDX-License-Identifier: MIT
"""Trains the network that tells palm from back and where fingers have their roots: face.py --data SET --out face.pt [--minutes 30].

It sees a hand turned upright and scaled by its fingertips, thumb right. src/find runs the same layers
in the same order; export.py writes their weights there. Log odds of the palm, then x and y of each
root from the picture's middle, in halves of its side, y down.
"""
import cv2
import numpy as np
import torch
import torch.nn as nn
import torch.nn.functional as F

from network import HEIGHT, WIDTH, Finder, Separable
from samples import MODEL_TIPS, OPEN, PALM, PHOTOGRAPHED, WHOLE, Samples, thumb_right
from train import DEVICE, Stream, Training, as_input, begun, outputs

SIDE = 96  # pixels
CENTRE, ACROSS = np.array([0.01, -0.02]), 0.25  # of what it sees, about an average hand, metres
# Roots of an average hand's fingers, thumb right, metres.
ROOTS = np.array([[.05, -.04], [.024, .014], [0, .017], [-.021, .012], [-.04, -.002]])
# Creases of an average palm, metres: along the fingers' roots, across, and around the thumb.
CREASES = [np.array(c) for c in ([[-.046, -.024], [-.02, -.016], [0, -.008], [.012, .004]], [[.036, -.012], [.012, -.022], [-.012, -.034], [-.03, -.05]],
                                 [[.036, -.012], [.02, -.03], [.008, -.055], [.008, -.085]])]
# Real hands differ from what it learns by: in so many of them it is taught to be wrong, and so never surer.
UNSURE = 0.03
ROOTS_COUNT = 4.0  # against the face, of the loss
TIP_SIGMA = 0.04  # of the fingertips by which it is turned and scaled, share of the span


class FaceNetwork(nn.Module):
    def __init__(self):
        super().__init__()
        self.stem = nn.Conv2d(3, 16, 3, 2, 1, bias=False)
        self.stem_norm = nn.BatchNorm2d(16)
        self.body = nn.Sequential(Separable(16, 32, 3), Separable(32, 48, 3, 2), Separable(48, 48, 5), Separable(48, 64, 3, 2),
                                  Separable(64, 64, 5), Separable(64, 64, 5), Separable(64, 32, 3, 2))
        self.drop = nn.Dropout(0.3)
        self.head = nn.Conv2d(32, 11, SIDE // 16)

    def forward(self, x):
        x = self.body(F.relu(self.stem_norm(self.stem(x))))
        return torch.cat([self.head(self.drop(x))[:, :1, 0, 0], self.head(x)[:, 1:, 0, 0]], 1)

    def convolutions(self):
        """As network.py's."""
        out = [(self.stem, self.stem_norm)]
        for s in self.body:
            out += [(s.depth, s.depth_norm), (s.point, s.point_norm)]
        return out + [(self.head, None)]


def seen(places):
    """Places in the plane of an average hand as the network sees them, pixels."""
    return (places - CENTRE) * [SIDE / ACROSS, -SIDE / ACROSS] + (SIDE - 1) / 2


def upright(tips):
    """The similarity (2 x 3), with a reflection for a hand with the thumb left, that takes a picture's pixels to the network's."""
    model = seen(MODEL_TIPS)
    mirror = 1 if thumb_right(tips) else -1
    a = (tips - tips.mean(0)) * [mirror, 1] @ [1, 1j]
    b = (model - model.mean(0)) @ [1, 1j]
    z = np.vdot(a, b) / np.vdot(a, a).real
    L = np.array([[z.real, -z.imag], [z.imag, z.real]]) @ np.diag([mirror, 1])
    return np.column_stack([L, model.mean(0) - L @ tips.mean(0)])


class FaceSamples(Samples):
    def __init__(self, folder, seed, held_out=False):
        super().__init__(folder, seed)
        faces, kinds = self.hands.more['faces'], self.hands.more['kinds']
        for k in range(4):
            which = np.nonzero((kinds == k) & (faces >= 0))[0]
            if k == OPEN:  # some people are kept to see how it goes
                which = which[np.arange(len(which)) % 12 == 0 if held_out else np.arange(len(which)) % 12 != 0]
            self.of_kind[k] = which
        self.held_out = held_out

    def wrinkles(self, canvas, tips, roots, back):
        """Dark across the knuckles of fingers, as real backs have it and rendered ones do not; on palms anywhere."""
        r = self.rng
        window = np.stack(np.mgrid[-14:15, -14:15][::-1], -1)
        deep, long, wide = r.uniform(0.05, 0.65), r.uniform(0.8, 3.2), r.uniform(2, 6)
        for at in (r.normal(0.57, 0.04), r.normal(0.3, 0.03), r.normal(1.05, 0.06)) if back else r.uniform(0.2, 1.1, 2):
            share = r.uniform(0.3 if back else 0, 1)
            for tip, root in zip(tips, roots):
                along = (root - tip) / np.linalg.norm(root - tip)
                place = tip + at * (root - tip)
                x, y = np.rint(place).astype(int)
                if not (14 <= x < WIDTH - 14 and 14 <= y < HEIGHT - 14):
                    continue
                off = window + [x, y] - place
                dark = share * deep * r.uniform(0.5, 1) * np.exp(-0.5 * ((off @ along) / long) ** 2 - 0.5 * ((off @ [-along[1], along[0]]) / wide) ** 2)
                canvas[y - 14:y + 15, x - 14:x + 15] *= (1 - dark)[..., None]

    def relief(self, canvas, tips, roots, back):
        """Real backs have tendons, knuckles and nails, real palms creases, which rendered ones hardly have: drawn, lit from a side."""
        r = self.rng
        average, ones = np.vstack([MODEL_TIPS, ROOTS]), lambda n: np.ones((n, 1))
        to_picture = np.linalg.lstsq(np.hstack([average, ones(10)]), np.vstack([tips, roots]), rcond=None)[0]
        place = lambda points: np.hstack([points, ones(len(points))]) @ to_picture
        height = np.zeros((HEIGHT, WIDTH), np.float32)

        def lines(paths, high, wide):
            drawn = np.zeros_like(height)
            for path in paths:
                cv2.polylines(drawn, [np.rint(16 * place(path)).astype(np.int32)], False, 1.0, 1, cv2.LINE_AA, 4)
            drawn = cv2.GaussianBlur(drawn, (0, 0), wide)
            height[:] += high * drawn / max(drawn.max(), 1e-6)

        fingers = [k for k in range(1, 5) if r.random() < 0.8]
        if back:
            lines([np.array([[0.3 * ROOTS[k, 0], r.uniform(-0.085, -0.05)], ROOTS[k] + r.normal(0, 0.002, 2)]) for k in fingers],
                  r.uniform(0, 2.5), r.uniform(1.2, 3))
            lines([ROOTS[k] + np.array([[-0.002, 0], [0.002, 0]]) for k in fingers], r.uniform(-0.3, 1.5), r.uniform(2, 4))
            if r.random() < 0.8:
                self.nails(canvas, tips, roots)
        else:
            kept = [c + r.normal(0, 0.003, c.shape) for c in CREASES if r.random() < 0.8]
            lines(kept, -r.uniform(0.2, 1.2), r.uniform(0.6, 1.6))
            lines([ROOTS[k] + np.array([[-0.008, 0.004], [0.008, 0.004]]) + r.normal(0, 0.002, 2) for k in fingers], -r.uniform(0, 0.8), r.uniform(0.6, 1.4))
        angle, deep = r.uniform(0, 2 * np.pi), r.uniform(0, 0.8)
        slope = np.cos(angle) * cv2.Sobel(height, cv2.CV_32F, 1, 0, scale=0.125) + np.sin(angle) * cv2.Sobel(height, cv2.CV_32F, 0, 1, scale=0.125)
        canvas *= np.exp(np.clip(2 * deep * slope + r.uniform(0, 0.35) * height, -0.7, 0.5))[..., None]
        np.clip(canvas, 0, 255, out=canvas)

    def nails(self, canvas, tips, roots):
        r = self.rng
        bright, tint = np.exp(r.normal(0.15, 0.2)), np.exp(r.normal(0, 0.06, 3))
        for f, (tip, root) in enumerate(zip(tips, roots)):
            if r.random() < (0.5 if f == 0 else 0.1):
                continue
            down = root - tip
            long = 0.085 * np.linalg.norm(down) * r.uniform(0.7, 1.2)
            plate = np.zeros((HEIGHT, WIDTH), np.float32)
            middle, axes = tip + down * r.uniform(0.07, 0.12), np.array([long, r.uniform(0.65, 1) * long])
            cv2.ellipse(plate, np.rint(16 * middle).astype(int).tolist(), np.maximum(np.rint(16 * axes), 8).astype(int).tolist(),
                        float(np.rad2deg(np.arctan2(down[1], down[0]))), 0, 360, 1.0, -1, cv2.LINE_AA, 4)
            canvas *= 1 + plate[..., None] * (bright * tint - 1)

    def sample(self):
        """What the network sees, and what it is to say; roots that are not known are NaN."""
        r = self.rng
        canvas = self.background()
        kind = r.choice([OPEN, PHOTOGRAPHED, WHOLE], p=[1, 0, 0] if self.held_out else [0.8, 0.12, 0.08])
        i = self.pick(kind)
        picture, tips = self.hands[i], self.hands.more['tips'][i]
        span = np.linalg.norm(tips[0] - tips[4])
        M = upright(tips + r.normal(0, TIP_SIGMA * span, tips.shape))
        corner = np.array([WIDTH - SIDE, HEIGHT - SIDE]) // 2
        M[:, 2] += corner
        if kind != WHOLE and r.random() < 0.25:  # before a window, in a dark room
            canvas *= r.uniform(1.2, 2.0) if r.random() < 0.5 else r.uniform(0.1, 0.7)
            np.clip(canvas, 0, 255, out=canvas)
        self.paste(canvas, picture, M, 0.5)
        if kind == OPEN:
            roots = self.hand_tips(M, self.hands.more['roots'][i])
            hand = self.hand_tips(M, tips), roots, self.hands.more['faces'][i] != PALM
            if r.random() < 0.75:
                self.wrinkles(canvas, *hand)
            if r.random() < 0.75:
                self.relief(canvas, *hand)
        if r.random() < 0.4:
            self.lamp(canvas, SIDE)
        if r.random() < 0.3:  # a small hand, enlarged
            canvas = cv2.GaussianBlur(canvas, (0, 0), r.uniform(0.5, 2.6))
        elif r.random() < 0.3:
            self.sharpen(canvas)
        picture = self.finish(canvas)[corner[1]:corner[1] + SIDE, corner[0]:corner[0] + SIDE]
        roots = (roots - corner - (SIDE - 1) / 2) / (SIDE / 2) if kind == OPEN else np.full((5, 2), np.nan)
        return np.ascontiguousarray(picture), np.append(self.hands.more['faces'][i] == PALM, roots).astype(np.float32)


def network_of(trained):
    """The network, this or the finder, that has these weights, and what draws its samples."""
    kind, samples = (Finder, Samples) if 'down1.depth.weight' in trained else (FaceNetwork, FaceSamples)
    net = kind()
    net.load_state_dict(trained)
    return net, samples


def losses(said, truth):
    """Of the face, and how far off roots are on average, in halves of the picture's side."""
    palm, known = truth[:, 0], ~torch.isnan(truth[:, 1])
    off = (said[known, 1:] - truth[known, 1:]).abs().mean()
    return F.binary_cross_entropy_with_logits(said[:, 0], palm + UNSURE * (1 - 2 * palm)), off


def main():
    a, net = begun(FaceNetwork, batch=64, minutes=30)
    held_out = FaceSamples(a.data, 99, True)
    held = [held_out.sample() for _ in range(1500)]
    pictures_held, truth = torch.from_numpy(np.stack([p for p, _ in held])).to(DEVICE), torch.from_numpy(np.stack([y for _, y in held])).to(DEVICE)
    training, sums = Training(net, a, weight_decay=0.05), np.zeros(2)

    def report():
        with torch.no_grad():
            said = torch.cat([training.mean(as_input(s)) for s in pictures_held.split(250)])
            face, off = losses(said, truth)
        right = ((said[:, 0] > 0) == (truth[:, 0] > 0.5)).float().mean()
        print(f'{training.seconds() / 60:5.1f} min {training.step * a.batch} samples, losses {sums[0] / 300:.3f} {sums[1] / 300:.4f}; held out: '
              f'{100 * right:.1f} % right, losses {face:.3f} {off:.4f}', flush=True)
        training.save()

    for pictures, truth_of in training.batches(Stream(FaceSamples, a.data, a.seed, FaceSamples.sample)):
        face, off = losses(outputs(net, pictures), truth_of)
        training.learn(face + ROOTS_COUNT * off)
        sums += face.item(), off.item()
        if training.step % 300 == 0:
            report()
            sums[:] = 0
    report()


if __name__ == '__main__':
    main()
