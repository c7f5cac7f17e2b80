// SPDX-License-Identifier: MIT
#include "handyar/planar_pose.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>
#include <utility>

#include "pose/so3.hpp"

namespace handyar {
namespace {

using Points = std::span<const Eigen::Vector2d>;

/// Centre and extent of a point set.
struct Spread {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  double larger = 0, smaller = 0;  ///< standard deviations along the principal axes

  explicit Spread(Points points) {
    for (const Eigen::Vector2d& p : points) mean += p;
    mean /= static_cast<double>(points.size());
    double xx = 0, xy = 0, yy = 0;
    for (const Eigen::Vector2d& p : points) {
      const Eigen::Vector2d d = p - mean;
      xx += d.x() * d.x();
      xy += d.x() * d.y();
      yy += d.y() * d.y();
    }
    const double n = static_cast<double>(points.size());
    const double half = 0.5 * (xx + yy), root = std::hypot(0.5 * (xx - yy), xy);
    larger = std::sqrt((half + root) / n);
    smaller = std::sqrt(std::max(0.0, (half - root) / n));
  }

  /// Four points say something only as a plane; NaN compares false.
  bool is_planar() const { return std::isfinite(larger) && smaller > 1e-3 * larger; }
};

/// Homography from the plane, moved to its centre and scaled to unit size, to the image, with
/// h33 = 1: the depth of the centre, which is not zero, is the scale.
std::optional<Eigen::Matrix3d> homography(Points plane, const Spread& spread, Points image) {
  using Matrix8d = Eigen::Matrix<double, 8, 8>;
  using Vector8d = Eigen::Matrix<double, 8, 1>;
  Matrix8d N = Matrix8d::Zero();
  Vector8d rhs = Vector8d::Zero();
  for (std::size_t i = 0; i < plane.size(); ++i) {
    const Eigen::Vector2d p = (plane[i] - spread.mean) / spread.larger;
    const Eigen::Vector2d& q = image[i];
    Vector8d u, v;
    u << p.x(), p.y(), 1, 0, 0, 0, -q.x() * p.x(), -q.x() * p.y();
    v << 0, 0, 0, p.x(), p.y(), 1, -q.y() * p.x(), -q.y() * p.y();
    N += u * u.transpose() + v * v.transpose();
    rhs += q.x() * u + q.y() * v;
  }
  // Three points on a line among four leave the system singular although the set is planar.
  const Eigen::LDLT<Matrix8d> ldlt(N);
  const Vector8d D = ldlt.vectorD();
  if (!(D.minCoeff() > 1e-13 * D.maxCoeff())) return std::nullopt;
  const Vector8d h = ldlt.solve(rhs);
  if (!h.allFinite()) return std::nullopt;
  Eigen::Matrix3d H;
  H << h[0], h[1], h[2], h[3], h[4], h[5], h[6], h[7], 1;
  return H;
}

/// The two rotations of a plane whose image near the plane's origin is q + J p (IPPE, section 5).
std::array<Eigen::Matrix3d, 2> rotations(const Eigen::Vector2d& q, const Eigen::Matrix2d& J) {
  // In a frame with its z axis on the ray through q, perspective at q becomes a scaling.
  const Eigen::Matrix3d R_ray =
      so3::between(Eigen::Vector3d::UnitZ(), q.homogeneous()).toRotationMatrix();
  const Eigen::Matrix2d B = R_ray.topLeftCorner<2, 2>() - q * R_ray.block<1, 2>(2, 0);
  const Eigen::Matrix2d A = B.inverse() * J;

  const Eigen::Matrix2d AAt = A * A.transpose();
  const double half = 0.5 * AAt.trace();
  const double gamma2 = half + std::hypot(0.5 * (AAt(0, 0) - AAt(1, 1)), AAt(0, 1));
  const Eigen::Matrix2d R22 = A / std::sqrt(gamma2);

  // The third row makes the first two columns orthonormal; its sign is the ambiguity.
  const Eigen::Matrix2d G = Eigen::Matrix2d::Identity() - R22.transpose() * R22;
  Eigen::Vector2d b(std::sqrt(std::max(0.0, G(0, 0))), std::sqrt(std::max(0.0, G(1, 1))));
  if (G(0, 1) < 0) b.y() = -b.y();

  std::array<Eigen::Matrix3d, 2> solutions;
  for (Eigen::Matrix3d& R : solutions) {
    Eigen::Matrix3d S;
    S.col(0) << R22.col(0), b.x();
    S.col(1) << R22.col(1), b.y();
    S.col(0).normalize();
    S.col(1) = (S.col(1) - S.col(0).dot(S.col(1)) * S.col(0)).normalized();
    S.col(2) = S.col(0).cross(S.col(1));
    R = R_ray * S;
    b = -b;
  }
  return solutions;
}

/// The translation of least algebraic error for a rotation, and the reprojection error then.
std::optional<PlanarPose> with_translation(const Eigen::Matrix3d& R, Points plane, Points image) {
  Eigen::Matrix3d N = Eigen::Matrix3d::Zero();
  Eigen::Vector3d rhs = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < plane.size(); ++i) {
    Eigen::Matrix<double, 2, 3> A;
    A << 1, 0, -image[i].x(), 0, 1, -image[i].y();
    const Eigen::Matrix3d AtA = A.transpose() * A;
    N += AtA;
    rhs -= AtA * (R.leftCols<2>() * plane[i]);
  }
  PlanarPose pose;
  pose.T_camera_plane.linear() = R;
  pose.T_camera_plane.translation() = N.ldlt().solve(rhs);
  double sum = 0;
  for (std::size_t i = 0; i < plane.size(); ++i) {
    const Eigen::Vector3d p = R.leftCols<2>() * plane[i] + pose.T_camera_plane.translation();
    if (!(p.z() > 0)) return std::nullopt;
    sum += (p.hnormalized() - image[i]).squaredNorm();
  }
  pose.rms = std::sqrt(sum / static_cast<double>(plane.size()));
  if (!std::isfinite(pose.rms)) return std::nullopt;
  return pose;
}

}  // namespace

std::optional<std::array<PlanarPose, 2>> solve_planar(Points plane, Points image) noexcept {
  if (plane.size() < 4 || plane.size() != image.size()) return std::nullopt;
  const Spread plane_spread(plane), image_spread(image);
  if (!plane_spread.is_planar() || !image_spread.is_planar()) return std::nullopt;
  const std::optional<Eigen::Matrix3d> H = homography(plane, plane_spread, image);
  if (!H) return std::nullopt;

  const Eigen::Vector2d q = H->topRightCorner<2, 1>();
  const Eigen::Matrix2d J = H->topLeftCorner<2, 2>() - q * H->bottomLeftCorner<1, 2>();
  if (!(std::abs(J.determinant()) > 1e-12)) return std::nullopt;

  const std::array<Eigen::Matrix3d, 2> R = rotations(q, J);
  std::optional<PlanarPose> first = with_translation(R[0], plane, image);
  std::optional<PlanarPose> second = with_translation(R[1], plane, image);
  if (!first || !second) return std::nullopt;
  if (second->rms < first->rms) std::swap(first, second);
  return std::array{*first, *second};
}

}  // namespace handyar
