# SPDX-License-Identifier: MIT
"""Writes trained weights as C++: export.py finder.pt ../../src/find/finder_weights.inc, or face.pt
../../src/find/face_weights.inc.

Batch normalisation is folded into the convolutions; each output's weights become 8-bit with a scale
of their own.
"""
import sys

import numpy as np
import torch

from face import network_of


def blocks(net):
    """(weights [..., outputs], biases) of each convolution, its normalisation folded in."""
    for conv, norm in net.convolutions():
        w = conv.weight.detach().numpy()
        if norm is None:
            b = conv.bias.detach().numpy()
        else:
            k = (norm.weight / torch.sqrt(norm.running_var + norm.eps)).detach().numpy()
            w, b = w * k[:, None, None, None], (norm.bias - norm.running_mean * torch.from_numpy(k)).detach().numpy()
        yield np.transpose(w, (2, 3, 1, 0)).reshape(-1, w.shape[0]), b


def quantised(w):
    scale = np.maximum(np.abs(w).max(0), 1e-8) / 127
    return np.round(w / scale).astype(int), scale


def main():
    net = network_of(torch.load(sys.argv[1]))[0].eval()
    weights, scales, table = [], [], []
    for w, b in blocks(net):
        q, s = quantised(w)
        weights += q.reshape(-1).tolist()
        scales += s.tolist() + b.tolist()
        table.append((q.size, q.shape[1]))

    def lines(numbers, form):
        text, line = [], ' '
        for n in numbers:
            item = ' ' + form(n) + ','
            if len(line) + len(item) > 100:
                text.append(line)
                line = ' '
            line += item
        return '\n'.join(text + [line])

    with open(sys.argv[2], 'w') as f:
        f.write('// SPDX-License-Identifier: MIT\n// Made by tools/finder/export.py; do not edit.\n\n')
        f.write('constexpr layers::Block kBlocks[] = {\n%s};\n' % lines(table, lambda t: '{%d, %d}' % t))
        f.write('/// Scales of a block, then its biases.\nconstexpr float kScales[] = {\n%s};\n'
                % lines(scales, lambda x: '%.7ef' % x))
        f.write('constexpr std::int8_t kWeights[] = {\n%s};\n' % lines(weights, str))
    print(len(weights), 'weights,', len(scales) // 2, 'scales')


if __name__ == '__main__':
    main()
