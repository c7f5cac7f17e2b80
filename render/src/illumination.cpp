// SPDX-License-Identifier: MIT
#include "illumination.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace handyar::render {
namespace {

constexpr double kNewFrameWeight = 0.12;  // the light of a room changes over about ten frames
constexpr float kMeanAlbedo = 0.30f;      // a room sends back about a third of its light,
constexpr float kLightAlbedo = 0.65f;     // its lightest tenth about two thirds
constexpr float kSkinAlbedo = 0.33f;      // between the darkest skin and the lightest
constexpr float kCast = 0.45f;            // share of the frame's colour cast that is the light's

/// Light is coloured less than the things it falls on.
Eigen::Vector3f light_of(const Eigen::Vector3f& seen) {
  const float grey = seen.dot(Eigen::Vector3f(0.2126f, 0.7152f, 0.0722f));
  return (kCast * seen + (1 - kCast) * Eigen::Vector3f::Constant(grey)) / kMeanAlbedo;
}

/// The luminance that a tenth of the pixels exceed.
float lightest_tenth(const cv::Mat& rgb) {
  std::vector<float> luminance;
  for (auto it = rgb.begin<cv::Vec3f>(); it != rgb.end<cv::Vec3f>(); ++it)
    luminance.push_back(0.2126f * (*it)[0] + 0.7152f * (*it)[1] + 0.0722f * (*it)[2]);
  const auto at = luminance.begin() + static_cast<std::ptrdiff_t>(luminance.size() * 9 / 10);
  std::nth_element(luminance.begin(), at, luminance.end());
  return *at;
}

/// Mean linear luminance under the mask; 0 where there is too little of it.
float luminance_on(const HandMask& hand, const cv::Mat& frame_bgr) {
  constexpr int kEvery = 4;
  double sum = 0;
  int count = 0;
  for (int v = 0; v < hand.height; v += kEvery)
    for (int u = 0; u < hand.width; u += kEvery) {
      const cv::Point px(hand.x0_px + u * hand.step_px, hand.y0_px + v * hand.step_px);
      if (!hand.data[v * hand.stride_bytes + u] || !px.inside({{}, frame_bgr.size()})) continue;
      const cv::Vec3b& c = frame_bgr.at<cv::Vec3b>(px);
      sum += 0.0722 * c[0] * c[0] + 0.7152 * c[1] * c[1] + 0.2126 * c[2] * c[2];
      ++count;
    }
  return count > 50 ? static_cast<float>(sum / (count * 255.0 * 255.0)) : 0;
}

Eigen::Vector3f vec(const cv::Vec3f& v) { return {v[0], v[1], v[2]}; }

}  // namespace

void Illumination::observe(const cv::Mat& frame_bgr, const HandMask& hand) {
  cv::Mat small, linear;
  cv::resize(frame_bgr, small, {32, 24}, 0, 0, cv::INTER_AREA);
  cv::cvtColor(small, small, cv::COLOR_BGR2RGB);
  small.convertTo(linear, CV_32F, 1 / 255.0);
  linear = linear.mul(linear);  // gamma 2, as the shaders take it
  if (blurred_.empty())
    blurred_ = linear;
  else
    cv::addWeighted(linear, kNewFrameWeight, blurred_, 1 - kNewFrameWeight, 0, blurred_);

  const float on_hand = luminance_on(hand, frame_bgr);
  if (on_hand > 0)
    on_hand_ += (on_hand_ > 0 ? static_cast<float>(kNewFrameWeight) : 1.0f) * (on_hand - on_hand_);

  const cv::Scalar mean = cv::mean(blurred_);
  const Eigen::Vector3f all = light_of(Eigen::Vector3f(mean[0], mean[1], mean[2]));
  // A dark wall does not make the light dim: the lightest tenth counts as well as the mean. And
  // even a black room leaves the object visible, even a white one leaves it some shading.
  const float brightness = all.maxCoeff();
  float wanted = 0.5f * (brightness + lightest_tenth(blurred_) / kLightAlbedo);
  // The hand says half of it; skin may be dark, so it says no more than that.
  if (on_hand_ > 0)
    wanted *= std::sqrt(std::clamp(on_hand_ / kSkinAlbedo / std::max(wanted, 0.05f), 0.4f, 2.5f));
  wanted = std::clamp(wanted, 0.25f, 1.25f);
  const float gain = wanted / std::max(brightness, 1e-4f);
  key_ = gain * all;

  cv::resize(blurred_, ambient_, {4, 3}, 0, 0, cv::INTER_AREA);
  for (auto it = ambient_.begin<cv::Vec3f>(); it != ambient_.end<cv::Vec3f>(); ++it) {
    // A surface sees half a world: mostly the mean, somewhat more of what it faces.
    const Eigen::Vector3f faced = gain * light_of(vec(*it));
    const Eigen::Vector3f light = 0.6f * key_ + 0.4f * faced.cwiseMin(2 * key_.maxCoeff());
    *it = {light.x(), light.y(), light.z()};
  }
}

}  // namespace handyar::render
