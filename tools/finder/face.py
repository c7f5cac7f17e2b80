# SPDX-License-Identifier: MIT
"""Trains the network that tells palm from back: face.py --data SET --out face.pt [--minutes 30].

It sees a hand turned upright and scaled by its fingertips, thumb right. src/find runs the same layers
in the same order; export.py writes their weights there. Log odds of the palm.
"""
import cv2
import numpy as np
import torch
import torch.nn as nn
import torch.nn.functional as F

from network import HEIGHT, WIDTH, Separable
from samples import MODEL_TIPS, OPEN, PALM, PHOTOGRAPHED, WHOLE, Samples, thumb_right
from train import DEVICE, Stream, Training, as_input, begun, outputs

SIDE = 64  # pixels
CENTRE, ACROSS = np.array([0.01, -0.01]), 0.26  # of what it sees, about an average hand, metres
# Roots of an average hand's fingers, thumb right, metres.
ROOTS = np.array([[.05, -.04], [.024, .014], [0, .017], [-.021, .012], [-.04, -.002]])
# Real hands differ from what it learns by: in so many of them it is taught to be wrong, and so never surer.
UNSURE = 0.03
TIP_SIGMA = 0.04  # of the fingertips by which it is turned and scaled, share of the span


class FaceNetwork(nn.Module):
    def __init__(self):
        super().__init__()
        self.stem = nn.Conv2d(3, 16, 3, 2, 1, bias=False)
        self.stem_norm = nn.BatchNorm2d(16)
        self.body = nn.Sequential(Separable(16, 32, 3), Separable(32, 48, 3, 2), Separable(48, 48, 5), Separable(48, 64, 3, 2),
                                  Separable(64, 64, 5), Separable(64, 64, 5))
        self.drop = nn.Dropout(0.3)
        self.head = nn.Conv2d(64, 1, SIDE // 8)

    def forward(self, x):
        x = F.relu(self.stem_norm(self.stem(x)))
        return self.head(self.drop(self.body(x)))[:, 0, 0, 0]

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

    def wrinkles(self, canvas, tips, back):
        """Dark across the knuckles of fingers, as real backs have it and rendered ones do not; on palms anywhere."""
        r = self.rng
        window = np.stack(np.mgrid[-9:10, -9:10][::-1], -1)
        roots = seen(ROOTS) + np.array([WIDTH - SIDE, HEIGHT - SIDE]) // 2
        deep, long, wide = r.uniform(0.05, 0.65), r.uniform(0.6, 2), r.uniform(1.2, 3.5)
        for at in (r.normal(0.57, 0.04), r.normal(0.3, 0.03), r.normal(1.05, 0.06)) if back else r.uniform(0.2, 1.1, 2):
            share = r.uniform(0.3 if back else 0, 1)
            for tip, root in zip(tips, roots):
                along = (root - tip) / np.linalg.norm(root - tip)
                place = tip + at * (root - tip)
                x, y = np.rint(place).astype(int)
                if not (9 <= x < WIDTH - 9 and 9 <= y < HEIGHT - 9):
                    continue
                off = window + [x, y] - place
                dark = share * deep * r.uniform(0.5, 1) * np.exp(-0.5 * ((off @ along) / long) ** 2 - 0.5 * ((off @ [-along[1], along[0]]) / wide) ** 2)
                canvas[y - 9:y + 10, x - 9:x + 10] *= (1 - dark)[..., None]

    def sample(self):
        """What the network sees, and whether it is a palm."""
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
        if kind == OPEN and r.random() < 0.75:
            self.wrinkles(canvas, self.hand_tips(M, tips), self.hands.more['faces'][i] != PALM)
        if r.random() < 0.4:
            self.lamp(canvas, SIDE)
        if r.random() < 0.3:  # a small hand, enlarged
            canvas = cv2.GaussianBlur(canvas, (0, 0), r.uniform(0.4, 1.5))
        elif r.random() < 0.3:
            self.sharpen(canvas)
        picture = self.finish(canvas)[corner[1]:corner[1] + SIDE, corner[0]:corner[0] + SIDE]
        return np.ascontiguousarray(picture), np.float32(self.hands.more['faces'][i] == PALM)


def main():
    a, net = begun(FaceNetwork, batch=64, minutes=30)
    held_out = FaceSamples(a.data, 99, True)
    held = [held_out.sample() for _ in range(1500)]
    pictures_held, truth = torch.from_numpy(np.stack([p for p, _ in held])).to(DEVICE), torch.tensor([y for _, y in held]).to(DEVICE)
    training, sum_loss = Training(net, a, weight_decay=0.05), 0.0

    def report():
        with torch.no_grad():
            odds = torch.cat([training.mean(as_input(s)) for s in pictures_held.split(250)])
        right = ((odds > 0) == (truth > 0.5)).float().mean()
        print(f'{training.seconds() / 60:5.1f} min {training.step * a.batch} samples loss {sum_loss / 300:.3f}; held out: '
              f'{100 * right:.1f} % right, loss {F.binary_cross_entropy_with_logits(odds, truth):.3f}', flush=True)
        training.save()

    for pictures, palm in training.batches(Stream(FaceSamples, a.data, a.seed, FaceSamples.sample)):
        loss = F.binary_cross_entropy_with_logits(outputs(net, pictures), palm + UNSURE * (1 - 2 * palm))
        training.learn(loss)
        sum_loss += loss.item()
        if training.step % 300 == 0:
            report()
            sum_loss = 0
    report()


if __name__ == '__main__':
    main()
