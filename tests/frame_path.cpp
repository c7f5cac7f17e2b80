// SPDX-License-Identifier: MIT
//
// Compiled twice: for the library as it is, and in namespace handyar_plain for the same sources
// without vectors.
#include "frame_path.hpp"

#include "handyar/chroma_noise.hpp"
#include "handyar/hand_search.hpp"

namespace handyar {
namespace {

void add(FramePath& to, const Mask& mask) {
  for (int v = 0; v < mask.height; ++v)
    for (int u = 0; u < mask.width; ++u) to.push_back(mask.at(u, v));
}

void add(FramePath& to, std::span<const Eigen::Vector2f> points) {
  for (const Eigen::Vector2f& p : points) to.insert(to.end(), {p.x(), p.y()});
}

}  // namespace

FramePath read_colors(const FrameBytes& f, int step_px) {
  const int width = f.width_px, height = f.height_px;
  ImageView frame{f.data, width, height, f.stride_bytes, static_cast<PixelFormat>(f.format)};
  frame.chroma = f.data + f.stride_bytes * height;
  frame.chroma_stride_bytes = f.stride_bytes;
  BinImage bins;
  bins.bins.resize(static_cast<std::size_t>(width) * height);
  read_bins(frame, {4, 2, width - 10, height - 5}, step_px, bins);
  FramePath path{bins.used().begin(), bins.used().end()};
  path.push_back(chroma_noise(bins));
  ChromaSmoother chroma;
  chroma.reserve(width);
  chroma.smooth(step_px, bins);
  path.insert(path.end(), bins.used().begin(), bins.used().end());
  return path;
}

FramePath look_for_hand(const FrameBytes& f) {
  const ImageView frame{f.data, f.width_px, f.height_px, f.stride_bytes};
  const int pixels = f.width_px * f.height_px;
  BinImage bins;
  bins.bins.resize(static_cast<std::size_t>(pixels));
  read_bins(frame, {0, 0, f.width_px, f.height_px}, 2, bins);
  FramePath path;
  MaskStages stages;
  stages.reserve(pixels);
  HandSearch search(stages);
  search.reserve(pixels);
  SkinModel skin;
  HandShape shape;
  for (int turn = 0; turn < 6; ++turn)  // all readings
    if (search.find(bins, skin, shape)) {
      path.push_back(shape.deviation);
      add(path, shape.tips);
      add(path, search.mask());
    }

  skin.widen();
  for (int frames = 0; frames < 3; ++frames)
    skin.learn(bins.used().first(9000), bins.used().last(20000));
  path.insert(path.end(), skin.ratios().begin(), skin.ratios().end());

  RegionFinder region;
  region.reserve(pixels);
  ExpectedRegion expected;
  expected.ratios.resize(static_cast<std::size_t>(pixels));
  shape.expect(bins.width, bins.height, expected);
  for (const ExpectedRegion& place : {ExpectedRegion{}, expected}) {
    region.classify(bins, skin.ratios(), place);
    region.remove_thin(3);
    region.grow_back(2);
    add(path, region.mask());
    Contour contour;
    contour.reserve(1 << 14);
    CurvatureFinder curvature;
    for (const Component& c : region.components(50)) {
      const Disc disc = region.deepest(c);
      path.insert(path.end(), {disc.center.x(), disc.center.y(), disc.radius});
      if (!contour.trace(region.mask(), c)) continue;
      curvature.find(contour, disc.radius);
      add(path, curvature.samples());
      for (const Extremum& tip : curvature.tips()) path.push_back(tip.cosine);
    }
    Mask mask, scratch;
    for (Mask* m : {&mask, &scratch}) m->reserve(pixels, f.width_px);
    mask.copy(region.mask());
    majority(mask, scratch);
    add(path, mask);
  }
  return path;
}

}  // namespace handyar
