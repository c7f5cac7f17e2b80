# SPDX-License-Identifier: MIT
"""Trains the finder: train.py --data DIR --out finder.pt [--minutes 50] [--start finder.pt]."""
import argparse
import copy
import time

import cv2
import numpy as np
import torch
import torch.nn.functional as F

from network import PALMS, TIPS, Finder
from samples import Samples

DEVICE = 'cuda' if torch.cuda.is_available() else 'cpu'
# Half as long numbers where the processor multiplies them.
SHORT = DEVICE == 'cpu' and 'avx512_bf16' in open('/proc/cpuinfo').read()


class Stream(torch.utils.data.IterableDataset):
    """What `draw` draws without end from samples of a seed of each worker's own."""

    def __init__(self, kind, folder, seed, draw):
        self.kind, self.folder, self.seed, self.draw = kind, folder, seed, draw

    def __iter__(self):
        cv2.setNumThreads(1)
        samples = self.kind(self.folder, self.seed + 1000 * torch.utils.data.get_worker_info().id)
        while True:
            yield self.draw(samples)


def picture_and_maps(samples):
    picture, hands = samples.sample()
    return picture, *samples.target(hands)


class Training:
    """Steps of a network whose learning rate falls to almost nothing by the end of the time, and the mean of its weights."""

    def __init__(self, net, asked, weight_decay, most_gradient=None):
        self.net, self.mean, self.asked, self.most_gradient = net.to(DEVICE, memory_format=torch.channels_last), copy.deepcopy(net).eval(), asked, most_gradient
        self.optimiser = torch.optim.AdamW(net.parameters(), lr=asked.rate, weight_decay=weight_decay)
        self.begun, self.step = time.time(), 0

    def seconds(self):
        return time.time() - self.begun

    def batches(self, stream):
        """Batches of the stream until the time is over."""
        a = self.asked
        for batch in torch.utils.data.DataLoader(stream, a.batch, num_workers=a.workers, prefetch_factor=4):
            done = self.seconds() / (60 * a.minutes)
            if done >= 1:
                break
            for g in self.optimiser.param_groups:
                g['lr'] = a.rate * min(1, (self.step + 1) / 200) * (0.5 * (1 + np.cos(np.pi * done)) + 0.003)
            yield [b.to(DEVICE) for b in batch]

    def learn(self, loss):
        self.optimiser.zero_grad()
        loss.backward()
        if self.most_gradient:
            torch.nn.utils.clip_grad_norm_(self.net.parameters(), self.most_gradient)
        self.optimiser.step()
        self.step += 1
        keep = min(0.998, self.step / (self.step + 50))
        with torch.no_grad():
            for m, n in zip(self.mean.state_dict().values(), self.net.state_dict().values()):
                m.copy_(keep * m + (1 - keep) * n if m.is_floating_point() else n)

    def save(self):
        torch.save({name: value.cpu() for name, value in self.mean.state_dict().items()}, self.asked.out)


def begun(net, batch, minutes):
    """The command line's wishes, and the network as they say that it begins."""
    ap = argparse.ArgumentParser()
    ap.add_argument('--data', required=True)
    ap.add_argument('--out', required=True)
    ap.add_argument('--start')
    ap.add_argument('--minutes', type=float, default=minutes)
    ap.add_argument('--rate', type=float, default=3e-3)
    ap.add_argument('--batch', type=int, default=batch)
    ap.add_argument('--workers', type=int, default=1)
    ap.add_argument('--threads', type=int, default=1)
    ap.add_argument('--seed', type=int, default=1)
    a = ap.parse_args()
    torch.manual_seed(a.seed)
    torch.set_num_threads(a.threads)
    net = net()
    if a.start:
        net.load_state_dict(torch.load(a.start))
    return a, net


def outputs(net, pictures):
    """What the network says of pictures, to learn from."""
    with torch.autocast('cpu', torch.bfloat16, enabled=SHORT):
        return net(as_input(pictures).contiguous(memory_format=torch.channels_last)).float()


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
    a, net = begun(Finder, batch=48, minutes=100)
    training = Training(net, a, weight_decay=1e-4, most_gradient=5)
    seen, sums = 0, np.zeros(2)
    for pictures, target, weight in training.batches(Stream(Samples, a.data, a.seed, picture_and_maps)):
        loss, parts = loss_of(outputs(net, pictures), target, weight)
        training.learn(loss)
        seen, sums = seen + len(pictures), sums + parts
        if training.step % 200 == 0:
            t = training.seconds()
            print(f'{t / 60:5.1f} min {seen} samples {seen / t:.0f}/s palms {sums[0] / 200:.3f} tips {sums[1] / 200:.3f}', flush=True)
            sums[:] = 0
            training.save()
    training.save()


if __name__ == '__main__':
    main()
