# SPDX-License-Identifier: MIT
"""Trains the finder: train.py --data DIR --out finder.pt [--minutes 50] [--start finder.pt]."""
import argparse
import time

import numpy as np
import torch
import torch.nn.functional as F

from network import PALMS, TIPS, Finder
from samples import Samples


class Stream(torch.utils.data.IterableDataset):
    def __init__(self, folder, seed):
        self.folder, self.seed = folder, seed

    def __iter__(self):
        import cv2
        cv2.setNumThreads(1)
        info = torch.utils.data.get_worker_info()
        samples = Samples(self.folder, self.seed + 1000 * info.id)
        while True:
            picture, hands = samples.sample()
            target, weight = samples.target(hands)
            yield picture, target, weight


def as_input(pictures):
    """BGR bytes to the network's input."""
    return (pictures.permute(0, 3, 1, 2).flip(1).float() - 127.5) / 64


def heat_loss(logits, target, weight):
    """Quality focal loss (Li et al., "Generalized Focal Loss", 2020): cross entropy with soft targets."""
    off = (target - torch.sigmoid(logits)).abs()
    entropy = F.binary_cross_entropy_with_logits(logits, target, reduction='none')
    return (weight * off ** 2 * entropy).sum() / (target > 0.8).float().sum().clamp(min=1)


def loss_of(out, target, weight):
    palms = heat_loss(out[:, PALMS], target[:, PALMS], weight[:, PALMS])
    tips = heat_loss(out[:, TIPS], target[:, TIPS], weight[:, TIPS])
    return palms + tips, (palms.item(), tips.item())


def main():
    ap = argparse.ArgumentParser()
    ap.add_argument('--data', required=True)
    ap.add_argument('--out', required=True)
    ap.add_argument('--start')
    ap.add_argument('--minutes', type=float, default=50)
    ap.add_argument('--rate', type=float, default=3e-3)
    ap.add_argument('--batch', type=int, default=48)
    ap.add_argument('--workers', type=int, default=1)
    ap.add_argument('--threads', type=int, default=2)
    ap.add_argument('--seed', type=int, default=1)
    a = ap.parse_args()
    torch.manual_seed(a.seed)
    torch.set_num_threads(a.threads)
    net, mean = Finder().to(memory_format=torch.channels_last), Finder()
    if a.start:
        net.load_state_dict(torch.load(a.start))
    mean.load_state_dict(net.state_dict())
    optimiser = torch.optim.AdamW(net.parameters(), lr=a.rate, weight_decay=1e-4)
    loader = torch.utils.data.DataLoader(Stream(a.data, a.seed), a.batch, num_workers=a.workers, prefetch_factor=4)
    begun, step, seen, sums = time.time(), 0, 0, np.zeros(2)
    for pictures, target, weight in loader:
        done = (time.time() - begun) / (60 * a.minutes)
        if done >= 1:
            break
        warm = min(1, (step + 1) / 200)
        for g in optimiser.param_groups:
            g['lr'] = a.rate * warm * (0.5 * (1 + np.cos(np.pi * done)) + 0.003)
        out = net(as_input(pictures).contiguous(memory_format=torch.channels_last))
        loss, parts = loss_of(out, target, weight)
        optimiser.zero_grad()
        loss.backward()
        torch.nn.utils.clip_grad_norm_(net.parameters(), 5)
        optimiser.step()
        step, seen, sums = step + 1, seen + len(pictures), sums + parts
        keep = min(0.998, step / (step + 50))
        with torch.no_grad():
            for m, n in zip(mean.state_dict().values(), net.state_dict().values()):
                m.copy_(keep * m + (1 - keep) * n if m.is_floating_point() else n)
        if step % 200 == 0:
            t = time.time() - begun
            print(f'{t / 60:5.1f} min {seen} samples {seen / t:.0f}/s palms {sums[0] / 200:.3f} tips {sums[1] / 200:.3f}', flush=True)
            sums[:] = 0
            torch.save(mean.state_dict(), a.out)
    torch.save(mean.state_dict(), a.out)


if __name__ == '__main__':
    main()
