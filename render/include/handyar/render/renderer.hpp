// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <span>

#include "handyar/camera.hpp"
#include "handyar/render/context.hpp"
#include "handyar/render/model.hpp"
#include "handyar/tracker.hpp"

namespace handyar::render {

/// What lies under an object and takes its shadow.
enum class Ground : std::uint8_t { none, hand, world };

/// A model placed before the camera.
struct Instance {
  int model = 0;  ///< from Renderer::add
  /// Pose of the object's frame: its origin is where it touches the ground, +z is up.
  Eigen::Isometry3d T_camera_object = Eigen::Isometry3d::Identity();
  double time_s = 0;                                 ///< a model that moves is shown as it is then
  double size_m = 0.09;                              ///< longest side
  Eigen::Vector3f colour = Eigen::Vector3f::Ones();  ///< multiplies the model's own, sRGB
  float opacity = 1;
  float glow = 0;  ///< 0 .. 1: shows that the object is chosen
  Ground ground = Ground::hand;
  float shadow = 1;  ///< strength of its shadow on the ground, 0 .. 1
};

/// The real hand, which hides what is behind it.
struct HandOccluder {
  HandMask mask;  ///< width 0: nothing is hidden
  /// With a pose the mask lies in the hand plane: only what is beyond that plane is hidden.
  /// Without, the hand is nearer than everything.
  std::optional<Eigen::Isometry3d> T_camera_hand;
  double finger_radius_m = 0.008;  ///< how far a finger's surface falls away towards its edge
};

/// Draws objects into camera frames.
///
/// OpenGL draws the objects, multisampled, into a picture with coverage of just the part of the
/// frame that they touch; it is laid over the frame on the CPU. Distortion: every vertex is
/// projected with the camera's own model, so the overlay is distorted and the frame is left as it
/// is; edges longer than a few degrees of view should be tessellated.
class Renderer {
 public:
  /// Draws in `context`, which is made current by every call. Throws io::Error without
  /// OpenGL 3.1.
  explicit Renderer(std::shared_ptr<Context> context = headless_context());
  ~Renderer();
  Renderer(Renderer&&) noexcept;
  Renderer& operator=(Renderer&&) noexcept;

  /// Takes a model over, made to stand on its origin with its longest side 1; returns its number.
  int add(const Model& model);

  /// Draws `instances` into an 8-bit BGR frame seen by `camera` (scaled to the frame's size when it
  /// differs). What is farther than 100 m or nearer than 1 cm is not drawn.
  void draw(cv::Mat& frame_bgr, const Camera& camera, std::span<const Instance> instances,
            const HandOccluder& hand = {});

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace handyar::render
