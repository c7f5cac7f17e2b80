// SPDX-License-Identifier: MIT
#include "bundle.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "rigid.hpp"

namespace handyar::world {
namespace {

constexpr int kIterations = 12;
constexpr double kPixelSigma_px = 0.7;
constexpr double kHuber = 2;  // standard deviations, beyond which an error counts linearly
constexpr double kNear_m = 0.02;

// The hand tells how the plane under it is tilted with this standard deviation.
constexpr double kTiltSigma_rad = 0.06;

using Matrix63d = Eigen::Matrix<double, 6, 3>;
using Matrix23d = Eigen::Matrix<double, 2, 3>;

/// What a robust error costs, and its weight in the normal equations.
struct Robust {
  double cost, weight;
  explicit Robust(double sigmas)
      : cost(sigmas <= kHuber ? sigmas * sigmas : kHuber * (2 * sigmas - kHuber)),
        weight(sigmas <= kHuber ? 1 : kHuber / sigmas) {}
};

/// The same for being off the plane: things stand on it, so that what is far off says nothing.
struct OffPlane {
  double cost, weight;
  explicit OffPlane(double sigmas)
      : cost(4 * std::log1p(sigmas * sigmas / 4)), weight(1 / (1 + sigmas * sigmas / 4)) {}
};

struct Ray {
  int camera;  // a free one's number, -1: stays
  int keyframe;
  Eigen::Vector2d px;
  Matrix63d W = Matrix63d::Zero();
};

struct Point {
  int index;
  std::vector<Ray> rays;
  Eigen::Matrix3d H = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  Matrix23d W_tilt = Matrix23d::Zero();
};

class Problem {
 public:
  Problem(WorldMap& map, std::span<const int> free)
      : map_(map), plane_height_m_(-map.hand_thickness_m) {
    std::vector<int> camera_of(map.keyframes.size(), -1);
    for (const int k : free)
      if (k != 0)
        camera_of[static_cast<std::size_t>(k)] = static_cast<int>(keyframes_.size()),
        keyframes_.push_back(k);
    std::vector<int> slot(map.points.size(), -1);
    for (const int k : free)
      for (const Observation& o : map.keyframes[static_cast<std::size_t>(k)].observations)
        if (int& s = slot[static_cast<std::size_t>(o.point)]; s < 0) {
          s = static_cast<int>(points_.size());
          points_.push_back({o.point, {}});
        }
    for (std::size_t k = 0; k < map.keyframes.size(); ++k)
      for (const Observation& o : map.keyframes[k].observations)
        if (const int s = slot[static_cast<std::size_t>(o.point)]; s >= 0)
          points_[static_cast<std::size_t>(s)].rays.push_back(
              {camera_of[k], static_cast<int>(k), o.px});
    // One ray alone tells no depth.
    std::erase_if(points_, [&](const Point& p) {
      return p.rays.size() < 2 && map_.points[static_cast<std::size_t>(p.index)].plane_sigma_m == 0;
    });
    for (int iteration = 0; iteration < kIterations; ++iteration) fit_tilt();
  }

  bool empty() const { return points_.empty(); }

  double cost() const {
    double sum = tilt_.squaredNorm() / (kTiltSigma_rad * kTiltSigma_rad);
    for (const Point& p : points_) {
      const MapPoint& at = map_.points[static_cast<std::size_t>(p.index)];
      if (at.plane_sigma_m > 0) sum += OffPlane(off_plane_m(at) / at.plane_sigma_m).cost;
      for (const Ray& ray : p.rays) {
        const Keyframe& keyframe = map_.keyframes[static_cast<std::size_t>(ray.keyframe)];
        const Eigen::Vector3d p_camera = keyframe.T_camera_world * at.p_world_m;
        if (p_camera.z() < kNear_m) return std::numeric_limits<double>::infinity();
        sum += Robust((ray.px - map_.camera.project(p_camera)).norm() / kPixelSigma_px).cost;
      }
    }
    return sum;
  }

  void linearise() {
    const auto cameras = static_cast<Eigen::Index>(keyframes_.size());
    H_.setZero(6 * cameras + 2, 6 * cameras + 2);
    b_.setZero(6 * cameras + 2);
    H_.bottomRightCorner<2, 2>().diagonal().setConstant(1 / (kTiltSigma_rad * kTiltSigma_rad));
    b_.tail<2>() = -tilt_ / (kTiltSigma_rad * kTiltSigma_rad);
    for (Point& p : points_) {
      const MapPoint& at = map_.points[static_cast<std::size_t>(p.index)];
      p.H.setZero();
      p.b.setZero();
      if (at.plane_sigma_m > 0) {
        const double off_m = off_plane_m(at), weight = weight_on_plane(at);
        const Eigen::RowVector3d J_point(-tilt_.x(), -tilt_.y(), 1);
        const Eigen::RowVector2d J_tilt = -at.p_world_m.head<2>();
        p.H += weight * J_point.transpose() * J_point;
        p.b -= weight * off_m * J_point.transpose();
        p.W_tilt = weight * J_tilt.transpose() * J_point;
        H_.bottomRightCorner<2, 2>() += weight * J_tilt.transpose() * J_tilt;
        b_.tail<2>() -= weight * off_m * J_tilt.transpose();
      }
      for (Ray& ray : p.rays) add(ray, at, p);
    }
  }

  /// The step for a damping; applied to the map.
  bool step(double damping) {
    Eigen::MatrixXd S = H_;
    Eigen::VectorXd s = b_;
    S.diagonal() += damping * H_.diagonal();
    std::vector<Eigen::Matrix3d> inverses(points_.size());
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const Point& p = points_[i];
      Eigen::Matrix3d H = p.H;
      H.diagonal() *= 1 + damping;
      H.diagonal().array() += 1e-6;  // a point that is seen by one ray only, along that ray
      inverses[i] = H.inverse();
      for (const Ray& a : p.rays) {
        if (a.camera < 0) continue;
        const Matrix63d Y = a.W * inverses[i];
        s.segment<6>(6 * a.camera) -= Y * p.b;
        for (const Ray& c : p.rays)
          if (c.camera >= 0) S.block<6, 6>(6 * a.camera, 6 * c.camera) -= Y * c.W.transpose();
        const Eigen::Matrix<double, 6, 2> with_tilt = Y * p.W_tilt.transpose();
        S.block<6, 2>(6 * a.camera, S.cols() - 2) -= with_tilt;
        S.block<2, 6>(S.rows() - 2, 6 * a.camera) -= with_tilt.transpose();
      }
      const Matrix23d Y_tilt = p.W_tilt * inverses[i];
      s.tail<2>() -= Y_tilt * p.b;
      S.bottomRightCorner<2, 2>() -= Y_tilt * p.W_tilt.transpose();
    }
    const Eigen::LDLT<Eigen::MatrixXd> solver(S);
    const Eigen::VectorXd motions = solver.solve(s);
    if (solver.info() != Eigen::Success || !motions.allFinite()) return false;
    tilt_ += motions.tail<2>();
    for (std::size_t i = 0; i < points_.size(); ++i) {
      Eigen::Vector3d rest = points_[i].b - points_[i].W_tilt.transpose() * motions.tail<2>();
      for (const Ray& ray : points_[i].rays)
        if (ray.camera >= 0) rest -= ray.W.transpose() * motions.segment<6>(6 * ray.camera);
      map_.points[static_cast<std::size_t>(points_[i].index)].p_world_m += inverses[i] * rest;
    }
    for (std::size_t k = 0; k < keyframes_.size(); ++k) {
      Keyframe& keyframe = map_.keyframes[static_cast<std::size_t>(keyframes_[k])];
      keyframe.T_camera_world =
          moved(motions.segment<6>(6 * static_cast<Eigen::Index>(k)), keyframe.T_camera_world);
    }
    return true;
  }

  struct Saved {
    std::vector<Eigen::Isometry3d> cameras;
    std::vector<Eigen::Vector3d> points;
    Eigen::Vector2d tilt;
  };
  Saved save() const {
    Saved saved{{}, {}, tilt_};
    for (const int k : keyframes_)
      saved.cameras.push_back(map_.keyframes[static_cast<std::size_t>(k)].T_camera_world);
    for (const Point& p : points_)
      saved.points.push_back(map_.points[static_cast<std::size_t>(p.index)].p_world_m);
    return saved;
  }
  void restore(const Saved& saved) {
    tilt_ = saved.tilt;
    for (std::size_t k = 0; k < keyframes_.size(); ++k)
      map_.keyframes[static_cast<std::size_t>(keyframes_[k])].T_camera_world = saved.cameras[k];
    for (std::size_t i = 0; i < points_.size(); ++i)
      map_.points[static_cast<std::size_t>(points_[i].index)].p_world_m = saved.points[i];
  }

 private:
  double off_plane_m(const MapPoint& at) const {
    return at.p_world_m.z() - plane_height_m_ - tilt_.dot(at.p_world_m.head<2>());
  }
  double weight_on_plane(const MapPoint& at) const {
    return OffPlane(off_plane_m(at) / at.plane_sigma_m).weight /
           (at.plane_sigma_m * at.plane_sigma_m);
  }

  /// A step to the tilt that the points show as they are.
  void fit_tilt() {
    Eigen::Matrix2d H = Eigen::Matrix2d::Identity() / (kTiltSigma_rad * kTiltSigma_rad);
    Eigen::Vector2d b = -tilt_ / (kTiltSigma_rad * kTiltSigma_rad);
    for (const Point& p : points_) {
      const MapPoint& at = map_.points[static_cast<std::size_t>(p.index)];
      if (at.plane_sigma_m == 0) continue;
      const Eigen::Vector2d along_m = at.p_world_m.head<2>();
      H += weight_on_plane(at) * along_m * along_m.transpose();
      b += weight_on_plane(at) * off_plane_m(at) * along_m;
    }
    tilt_ += H.ldlt().solve(b);
  }

  void add(Ray& ray, const MapPoint& at, Point& p) {
    const Keyframe& keyframe = map_.keyframes[static_cast<std::size_t>(ray.keyframe)];
    const Eigen::Vector3d p_camera = keyframe.T_camera_world * at.p_world_m;
    Eigen::Matrix<double, 2, 3> J;
    const Eigen::Vector2d error_px = ray.px - map_.camera.project(p_camera, &J);
    const double weight =
        Robust(error_px.norm() / kPixelSigma_px).weight / (kPixelSigma_px * kPixelSigma_px);
    const Eigen::Matrix<double, 2, 3> J_point = J * keyframe.T_camera_world.linear();
    p.H.noalias() += weight * J_point.transpose() * J_point;
    p.b.noalias() += weight * J_point.transpose() * error_px;
    if (ray.camera < 0) return;
    const Eigen::Matrix<double, 2, 6> J_camera = J * jacobian_of_motion(p_camera);
    H_.block<6, 6>(6 * ray.camera, 6 * ray.camera) += weight * J_camera.transpose() * J_camera;
    b_.segment<6>(6 * ray.camera) += weight * J_camera.transpose() * error_px;
    ray.W = weight * J_camera.transpose() * J_point;
  }

  WorldMap& map_;
  double plane_height_m_;  // of what the hand lay on, where it lay when it set the frame
  Eigen::Vector2d tilt_ = Eigen::Vector2d::Zero();  // how that plane rises along x and y
  std::vector<int> keyframes_;                      // by number of the free camera
  std::vector<Point> points_;
  Eigen::MatrixXd H_;
  Eigen::VectorXd b_;
};

}  // namespace

void adjust(WorldMap& map, std::span<const int> free) {
  Problem problem(map, free);
  if (problem.empty()) return;
  double cost = problem.cost(), damping = 1e-4;
  problem.linearise();
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    const Problem::Saved saved = problem.save();
    const bool stepped = problem.step(damping);
    const double now = stepped ? problem.cost() : cost;
    if (stepped && now < cost) {
      const bool done = cost - now < 1e-4 * cost;
      cost = now;
      damping = std::max(1e-7, damping / 5);
      if (done) return;
      problem.linearise();
    } else {
      problem.restore(saved);
      damping *= 10;
    }
  }
}

}  // namespace handyar::world
