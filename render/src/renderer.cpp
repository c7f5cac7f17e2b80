// SPDX-License-Identifier: MIT
#include "handyar/render/renderer.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "gl.hpp"
#include "gpu_model.hpp"
#include "gpu_texture.hpp"
#include "handyar/opencv/lens.hpp"
#include "illumination.hpp"
#include "matte.hpp"
#include "region.hpp"
#include "shaders.hpp"

namespace handyar::render {
namespace {

using Eigen::Vector3f;

constexpr int kSamples = 4;
/// Towards the lamp, in the camera frame: above, a little to the left, behind the camera.
const Vector3f kKeyDirection = Vector3f(-0.35f, -0.75f, -0.56f).normalized();

void set(GLint location, const Vector3f& v) { glUniform3fv(location, 1, v.data()); }

/// Binds a texture at `unit`, if there is one; the uniform at `is_there` says so.
void put_texture(const SharedTexture& texture, int unit, GLint is_there) {
  glUniform1i(is_there, texture != nullptr);
  glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
  glBindTexture(GL_TEXTURE_2D, texture ? GLuint(*texture) : 0);
}

/// Colour and depth, multisampled, and the single-sampled colour that it is resolved into.
struct Target {
  int width_px, height_px;
  gl::Framebuffer multisampled, resolved;
  gl::Renderbuffer colour, depth, resolved_colour;

  Target(int width, int height) : width_px(width), height_px(height) {
    GLint most = 0;
    glGetIntegerv(GL_MAX_SAMPLES, &most);
    const int samples = std::min(kSamples, most);
    glBindFramebuffer(GL_FRAMEBUFFER, multisampled);
    attach(colour, samples, GL_RGBA8, GL_COLOR_ATTACHMENT0);
    attach(depth, samples, GL_DEPTH_COMPONENT24, GL_DEPTH_ATTACHMENT);
    glBindFramebuffer(GL_FRAMEBUFFER, resolved);
    attach(resolved_colour, 0, GL_RGBA8, GL_COLOR_ATTACHMENT0);
  }

 private:
  void attach(GLuint buffer, int samples, GLenum format, GLenum where) const {
    glBindRenderbuffer(GL_RENDERBUFFER, buffer);
    glRenderbufferStorageMultisample(GL_RENDERBUFFER, samples, format, width_px, height_px);
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, where, GL_RENDERBUFFER, buffer);
  }
};

/// Lays a premultiplied BGRA picture over a BGR one.
void lay_over(const cv::Mat& bgra, cv::Mat frame_bgr) {
  for (int y = 0; y < bgra.rows; ++y) {
    const std::uint8_t* over = bgra.ptr(y);
    std::uint8_t* under = frame_bgr.ptr(y);
    for (int x = 0; x < bgra.cols; ++x, over += 4, under += 3) {
      if (over[3] == 0) continue;
      const int rest = 255 - over[3];
      for (int c = 0; c < 3; ++c)
        under[c] =
            static_cast<std::uint8_t>(std::min(255, over[c] + (under[c] * rest + 127) / 255));
    }
  }
}

}  // namespace

struct Renderer::Impl {
  std::shared_ptr<Context> context;
  gl::Program object{std::string(shaders::kCamera) + shaders::kObjectVertex,
                     std::string(shaders::kHand) + shaders::kObjectFragment,
                     shaders::kObjectAttributes};
  gl::Program ground{std::string(shaders::kCamera) + shaders::kGroundVertex,
                     std::string(shaders::kHand) + shaders::kGroundFragment};
  gl::VertexArray no_vertices;
  gl::Texture matte, ambient, mirrored;
  std::vector<GpuModel> models;
  std::optional<Target> target;
  Illumination light;
  cv::Mat overlay_bgra;

  explicit Impl(std::shared_ptr<Context> c) : context(std::move(c)) {}
  ~Impl() { context->make_current(); }  // what it owns is of this context

  void begin(const cv::Rect& region) const {
    glBindFramebuffer(GL_FRAMEBUFFER, target->multisampled);
    glViewport(0, 0, target->width_px, target->height_px);
    glEnable(GL_SCISSOR_TEST);
    glScissor(region.x, region.y, region.width, region.height);
    glEnable(GL_MULTISAMPLE);
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_LEQUAL);
    glDepthMask(GL_TRUE);
    glDisable(GL_CULL_FACE);
    glDisable(GL_BLEND);
    glClearColor(0, 0, 0, 0);
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  }

  /// What both programs know of camera and hand.
  void share(const gl::Program& program, const Camera& camera, const HandOccluder& hand,
             const cv::Rect& region) const {
    program.use();
    glUniform4f(program["fc"], float(camera.fx_px), float(camera.fy_px), float(camera.cx_px),
                float(camera.cy_px));
    std::array<float, 5> k;
    std::copy(camera.distortion.begin(), camera.distortion.end(), k.begin());
    glUniform1fv(program["k"], 5, k.data());
    glUniform1f(program["r2_max"], float(unfolded_r2(camera)));
    glUniform2f(program["size_px"], float(camera.width_px), float(camera.height_px));
    glUniform1i(program["matte"], 1);
    glUniform2i(program["matte_origin_px"], region.x, region.y);
    glUniform1i(program["hand"], hand.mask.width == 0 ? 0 : hand.T_camera_hand ? 2 : 1);
    if (hand.T_camera_hand) {
      const Eigen::Vector3d normal = hand.T_camera_hand->linear().col(2);
      set(program["hand_normal"], normal.cast<float>());
      glUniform1f(program["hand_offset_m"], float(normal.dot(hand.T_camera_hand->translation())));
    }
    glUniform1f(program["finger_radius_m"], float(hand.finger_radius_m));
  }

  void place(const gl::Program& program, const Instance& instance) const {
    const Eigen::Matrix4f T = instance.T_camera_object.matrix().cast<float>();
    glUniformMatrix4fv(program["T_camera_object"], 1, GL_FALSE, T.data());
    glUniform1f(program["size_m"], float(instance.size_m));
    glUniform1f(program["opacity"], instance.opacity);
    glUniform1f(program["glow"], instance.glow);
  }

  void draw_objects(std::span<const Instance> instances) {
    glUniform1i(object["surface"], 0);
    glUniform1i(object["ambient"], 2);
    glUniform1i(object["mirrored"], 3);
    glUniform1i(object["emission_surface"], 5);
    set(object["key"], light.key());
    set(object["key_direction"], kKeyDirection);
    for (const Instance& instance : instances) {
      if (instance.opacity <= 0) continue;
      place(object, instance);
      GpuModel& model = models[instance.model];
      const double periods = model.period_s > 0 ? instance.time_s / model.period_s : 0;
      for (GpuMesh& mesh : model.meshes) {
        mesh.move(periods - std::floor(periods));
        const Vector3f colour = mesh.material.colour.cwiseProduct(instance.colour);
        const float roughness = std::clamp(mesh.material.roughness, 0.18f, 1.0f);
        set(object["base_colour"], colour.cwiseProduct(colour));
        glUniform1f(object["roughness"], roughness);
        glUniform1f(object["shine"], std::max(1.0f, 2 / std::pow(roughness, 4.0f) - 2));
        glUniform1f(object["metallic"], mesh.material.metallic);
        set(object["emission"], mesh.material.emission.cwiseAbs2());
        put_texture(mesh.texture, 0, object["textured"]);
        put_texture(mesh.emission_texture, 5, object["emission_textured"]);
        glBindVertexArray(mesh.array);
        glDrawElements(GL_TRIANGLES, mesh.index_count, GL_UNSIGNED_INT, nullptr);
      }
    }
  }

  /// Shadows go under what is drawn already.
  void draw_grounds(std::span<const Instance> instances) const {
    glEnable(GL_BLEND);
    glBlendFunc(GL_ONE_MINUS_DST_ALPHA, GL_ONE);
    glDepthMask(GL_FALSE);
    glUniform1i(ground["shadow"], 4);
    glBindVertexArray(no_vertices);
    for (const Instance& instance : instances) {
      if (instance.opacity <= 0 || instance.ground == Ground::none) continue;
      place(ground, instance);
      const GpuModel& model = models[instance.model];
      const Vector3f lamp =
          instance.T_camera_object.linear().cast<float>().transpose() * kKeyDirection;
      // The shadow of a point half way up, no longer than the object is high.
      const float height = 0.45f * model.box.max().z();
      const Eigen::Vector2f shift = -height * lamp.head<2>() / std::max(lamp.z(), 0.45f);
      glUniform2f(ground["thrown"], shift.x(), shift.y());
      glUniform1f(ground["strength"], 0.2f + 0.3f * std::clamp(lamp.z() * 2, 0.0f, 1.0f));
      glUniform1f(ground["shade"], instance.shadow);
      glUniform1i(ground["on_hand"], instance.ground == Ground::hand);
      glActiveTexture(GL_TEXTURE4);
      glBindTexture(GL_TEXTURE_2D, model.shadow);
      glDrawArrays(GL_TRIANGLES, 0, 16 * 16 * 6);
    }
  }

  void read_back(const cv::Rect& region) {
    const int x1 = region.x + region.width, y1 = region.y + region.height;
    glBindFramebuffer(GL_READ_FRAMEBUFFER, target->multisampled);
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, target->resolved);
    glBlitFramebuffer(region.x, region.y, x1, y1, region.x, region.y, x1, y1, GL_COLOR_BUFFER_BIT,
                      GL_NEAREST);
    glBindFramebuffer(GL_READ_FRAMEBUFFER, target->resolved);
    overlay_bgra.create(region.size(), CV_8UC4);
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glReadPixels(region.x, region.y, region.width, region.height, GL_BGRA, GL_UNSIGNED_BYTE,
                 overlay_bgra.data);
  }
};

Renderer::Renderer(std::shared_ptr<Context> context) {
  context->make_current();
  impl_ = std::make_unique<Impl>(std::move(context));
}
Renderer::~Renderer() = default;
Renderer::Renderer(Renderer&&) noexcept = default;
Renderer& Renderer::operator=(Renderer&&) noexcept = default;

int Renderer::add(const Model& model) {
  impl_->context->make_current();
  impl_->models.emplace_back(model.standing());
  return static_cast<int>(impl_->models.size()) - 1;
}

void Renderer::draw(cv::Mat& frame_bgr, const Camera& camera, std::span<const Instance> instances,
                    const HandOccluder& hand) {
  CV_Assert(frame_bgr.type() == CV_8UC3);
  Impl& im = *impl_;
  im.light.observe(frame_bgr, hand.mask);
  const Camera seen = camera.scaled_to(frame_bgr.cols, frame_bgr.rows);
  const cv::Rect region = region_of(seen, instances, im.models);
  if (region.empty()) return;

  im.context->make_current();
  if (!im.target || im.target->width_px != frame_bgr.cols || im.target->height_px != frame_bgr.rows)
    im.target.emplace(frame_bgr.cols, frame_bgr.rows);
  const double distance_m = hand.T_camera_hand ? hand.T_camera_hand->translation().norm() : 0.5;
  const cv::Mat matte =
      hand_matte(hand.mask, region, seen.fx_px * hand.finger_radius_m / distance_m);
  upload(im.matte, 1, GL_RG8, matte.cols, matte.rows, GL_RG, GL_UNSIGNED_BYTE, matte.data);
  const cv::Mat &ambient = im.light.ambient(), &mirrored = im.light.mirrored();
  upload(im.ambient, 2, GL_RGB16F, ambient.cols, ambient.rows, GL_RGB, GL_FLOAT, ambient.data);
  upload(im.mirrored, 3, GL_RGB16F, mirrored.cols, mirrored.rows, GL_RGB, GL_FLOAT, mirrored.data);

  im.begin(region);
  im.share(im.object, seen, hand, region);
  im.draw_objects(instances);
  im.share(im.ground, seen, hand, region);
  im.draw_grounds(instances);
  im.read_back(region);
  lay_over(im.overlay_bgra, frame_bgr(region));
}

}  // namespace handyar::render
