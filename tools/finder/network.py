# SPDX-License-Identifier: MIT
"""The finder's network: a small fully convolutional encoder and decoder.

Input 3 x 120 x 160 (red, green, blue, each about -1 to 1), output OUTPUTS x 30 x 40. src/find runs
the same layers in the same order; export.py writes their weights there.
"""
import torch
import torch.nn as nn
import torch.nn.functional as F

WIDTH, HEIGHT, STRIDE = 160, 120, 4
CELLS_X, CELLS_Y = WIDTH // STRIDE, HEIGHT // STRIDE
# Maps: a palm with the thumb right, left; the tips.
PALMS, TIPS = slice(0, 2), slice(2, 7)
OUTPUTS = 7

CHANNELS = (16, 32, 64, 96)
BLOCKS = (4, 10)  # at the third and the fourth level


class DepthwiseOf5(torch.autograd.Function):
    """A depthwise convolution of 5 x 5. In bfloat16 oneDNN takes 10 to 12 times as long for the gradient of
    its weights as for four of 3 x 3, from which it is put together here."""

    @staticmethod
    def forward(context, x, weight):
        context.save_for_backward(x, weight)
        return F.conv2d(x, weight, None, 1, 2, 1, x.shape[1])

    @staticmethod
    def backward(context, gradient):
        x, weight = context.saved_tensors
        channels, by_weight = x.shape[1], torch.empty_like(weight)

        def gradients(x, weight, padding, of_input):
            return torch.ops.aten.convolution_backward(gradient, x, weight, None, [1, 1], [padding] * 2, [1, 1], False, [0, 0], channels,
                                                       [of_input, not of_input, False])[0 if of_input else 1]
        for v in (-1, 1):
            for u in (-1, 1):
                moved = F.pad(x, (1 - u, 1 + u, 1 - v, 1 + v)).contiguous(memory_format=torch.channels_last)
                by_weight[:, :, v + 1:v + 4, u + 1:u + 4] = gradients(moved, weight[:, :, :3, :3].contiguous(), 0, False)
        return gradients(x, weight, 2, True), by_weight


class Depthwise(nn.Conv2d):
    def __init__(self, channels, size, stride):
        super().__init__(channels, channels, size, stride, size // 2, groups=channels, bias=False)

    def forward(self, x):
        if self.training and self.kernel_size == (5, 5) and self.stride == (1, 1) and x.device.type == 'cpu':
            return DepthwiseOf5.apply(x, self.weight.to(x.dtype))
        return super().forward(x)


class Separable(nn.Module):
    """Depthwise, then pointwise; with a shortcut where sizes allow."""

    def __init__(self, inputs, outputs, size, stride=1):
        super().__init__()
        self.depth = Depthwise(inputs, size, stride)
        self.depth_norm = nn.BatchNorm2d(inputs)
        self.point = nn.Conv2d(inputs, outputs, 1, bias=False)
        self.point_norm = nn.BatchNorm2d(outputs)
        self.shortcut = stride == 1 and inputs == outputs

    def forward(self, x):
        y = F.relu(self.depth_norm(self.depth(x)))
        y = self.point_norm(self.point(y))
        return F.relu(x + y) if self.shortcut else F.relu(y)


class Finder(nn.Module):
    def __init__(self):
        super().__init__()
        a, b, c, d = CHANNELS
        self.stem = nn.Conv2d(3, a, 3, 2, 1, bias=False)
        self.stem_norm = nn.BatchNorm2d(a)
        self.down1 = Separable(a, b, 3, 2)
        self.at1 = Separable(b, b, 3)
        self.down2 = Separable(b, c, 3, 2)
        self.at2 = nn.Sequential(*[Separable(c, c, 5) for _ in range(BLOCKS[0])])
        self.down3 = Separable(c, d, 3, 2)
        self.at3 = nn.Sequential(*[Separable(d, d, 5) for _ in range(BLOCKS[1])])
        self.up2 = nn.Conv2d(d, c, 1)
        self.join2 = Separable(c, c, 3)
        self.up1 = nn.Conv2d(c, b, 1)
        self.join1 = nn.Sequential(Separable(b, b, 5), Separable(b, b, 5))
        self.head = nn.Conv2d(b, OUTPUTS, 1)
        nn.init.constant_(self.head.bias, -4.0)

    def forward(self, x):
        x = F.relu(self.stem_norm(self.stem(x)))
        x1 = self.at1(self.down1(x))
        x2 = self.at2(self.down2(x1))
        x3 = self.at3(self.down3(x2))
        y2 = self.join2(x2 + F.interpolate(self.up2(x3), scale_factor=2)[..., : x2.shape[2], :])
        y1 = self.join1(x1 + F.interpolate(self.up1(y2), scale_factor=2))
        return self.head(y1)

    def convolutions(self):
        """(convolution, its normalisation or None) in the order in which src/find/network.cpp reads them."""
        separable = lambda s: [(s.depth, s.depth_norm), (s.point, s.point_norm)]
        out = [(self.stem, self.stem_norm)]
        for s in (self.down1, self.at1, self.down2, *self.at2, self.down3, *self.at3):
            out += separable(s)
        out += [(self.up2, None)] + separable(self.join2) + [(self.up1, None)]
        for s in self.join1:
            out += separable(s)
        return out + [(self.head, None)]


if __name__ == '__main__':
    net = Finder()
    print(sum(p.numel() for p in net.parameters()), 'parameters', net(torch.zeros(1, 3, HEIGHT, WIDTH)).shape)
