// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/Geometry>

/// @file
/// Expressions of Eigen that most of our files use. Named here, in what is compiled once for all of them
/// (LimberCompileTime.cmake), they are not instantiated anew in each, which costs some milliseconds per
/// expression and file. Nobody calls this; docs/evidence/build-times.md says what it saves.
namespace limber::precompiled {

template <typename V>
double of_vectors(V& a, const V& b, double s) {
  a = V::Zero();
  a = V::Constant(s);
  a.setZero();
  a.setConstant(s);
  a = a + b;
  a = a - b;
  a = -b;
  a = s * b;
  a = b * s;
  a = b / s;
  a += b;
  a -= b;
  a += s * b;
  a -= s * b;
  a *= s;
  a /= s;
  a = a + s * b;
  a = a - s * b;
  a = s * a + s * b;
  a = a.cwiseProduct(b);
  a = b.cwiseAbs();
  a = b.cwiseSqrt();
  a = b.cwiseInverse();
  a << b;
  const bool finite = a.allFinite() && a.isZero();
  return finite
             ? a.norm() + a.squaredNorm() + a.dot(b) + (a - b).norm() + (a - b).squaredNorm() + a.sum() +
                   a.minCoeff() + a.maxCoeff() + b.cwiseAbs().maxCoeff() + a.normalized()[0] + (s * b).norm()
             : 0.0;
}

template <typename M>
void of_matrices(M& A, const M& B, double s) {
  A = M::Zero();
  A = M::Constant(s);
  A = M::Identity();
  A.setZero();
  A.setIdentity();
  A = B.transpose();
  A = A + B;
  A = A - B;
  A = -B;
  A = s * B;
  A += B;
  A -= B;
  A *= s;
  A = 0.5 * (B + B.transpose());
  A = B.cwiseAbs();
  A.diagonal().array() += s;
  s = A.norm() + A.squaredNorm() + A.trace() + A.maxCoeff() + A.diagonal().maxCoeff() + (A - B).norm();
}

template <int N>
void of_size(Eigen::Matrix<double, N, N>& A, Eigen::Matrix<double, N, 1>& a) {
  using Eigen::Matrix;
  const Matrix<double, N, N> B = A;
  const Matrix<double, N, 1> b = a;
  of_vectors(a, b, 2.0);
  of_matrices(A, B, 2.0);
  a = B * b;
  a = B.transpose() * b;
  a = a + B * b;
  a = a - B * b;
  a += B * b;
  a -= B * b;
  A = A * B;
  A = B.transpose() * B;
  A = B * B.transpose();
  A = A * B * A.transpose();
  A = b * b.transpose();
  A += b * b.transpose();
  A = b.asDiagonal();
  a = B.diagonal();
  a = B.diagonal().cwiseSqrt();
  a = B.col(0);
  a = B.row(0).transpose();
  A.col(0) = b;
  A.row(0) = b.transpose();
  A.diagonal() = b;
}

/// Poses.
inline void of_poses(Eigen::Matrix3d& R, Eigen::Vector3d& p, double s) {
  const Eigen::Matrix3d Q = R;
  const Eigen::Vector3d q = p;
  of_size<3>(R, p);
  p = R * q + p;
  p = R * (q - p);
  p = R.transpose() * (q - p);
  p = -(R.transpose() * q);
  p = Q * R * q;
  p = s * (R * q);
  p = s * R * q + p;
  R = Q.transpose() * R;
  R = R * Q.transpose();
  R = s * Q;
  p = q.cross(p);
  p = (q - p) / s;
  p.normalize();
  p = Eigen::Vector3d(s, s, s);
  p = Eigen::Vector3d::UnitX() + Eigen::Vector3d::UnitY() + Eigen::Vector3d::UnitZ();
  p.head<2>() = q.head<2>() / q.z();
  const Eigen::Quaterniond a(R);
  R = (a * a.conjugate()).toRotationMatrix();
  R = a.normalized().slerp(s, a).toRotationMatrix();
}

/// Vectors and matrices of pieces.
template <int N>
void of_pieces(Eigen::Matrix<double, N, 1>& a, Eigen::Matrix<double, N, N>& A, Eigen::Index i) {
  const auto b = a;
  const auto B = A;
  const Eigen::Vector3d p = b.template segment<3>(i) + b.template head<3>() - b.template tail<3>();
  a.template segment<3>(i) = p;
  a.template segment<3>(i) += p;
  a.template head<3>() = p;
  a.template tail<3>() = p;
  a.template segment<3>(i).setZero();
  a[0] = b.template tail<3>().norm() + b.template head<3>().norm() + b.template segment<3>(i).norm();
  Eigen::Matrix3d R = B.template block<3, 3>(i, i);
  R = B.template block<3, 3>(i, i).transpose();
  R = B.template topLeftCorner<3, 3>();
  A.template block<3, 3>(i, i) = R;
  A.template block<3, 3>(i, i) += R;
  A.template topLeftCorner<3, 3>() = R;
}

using ConstRef = Eigen::Ref<const Eigen::MatrixXd>;

inline void of_any_size(Eigen::MatrixXd& A, Eigen::VectorXd& a, Eigen::Index i, Eigen::Index n) {
  const Eigen::MatrixXd B = Eigen::MatrixXd::Zero(n, n) + Eigen::MatrixXd::Identity(n, n);
  const Eigen::VectorXd b = Eigen::VectorXd::Zero(n);
  A.setZero(n, n);
  A = Eigen::MatrixXd::Identity(n, n);
  A = B.transpose();
  A = A + B;
  A = A - B;
  A = 2.0 * B;
  A += B;
  A -= B;
  A.block(i, i, n, n) = B;
  A.block(i, i, n, n) += B;
  A = B.block(i, i, n, n);
  A = B.block(i, i, n, n).transpose();
  A.topRows(n) = B.topRows(n);
  A.middleRows(i, n) = B.middleRows(i, n);
  A.middleCols(i, n) = B.middleCols(i, n);
  A.leftCols(n) = B.leftCols(n);
  A.topLeftCorner(n, n) = B.topLeftCorner(n, n);
  A.col(i) = B.col(i);
  A.col(i) = b;
  A.row(i) = b.transpose();
  A.row(i) = B.row(i);
  A.diagonal() = b;
  A.diagonal().array() += 1.0;
  A.conservativeResize(n, n);
  a.setZero(n);
  a = Eigen::VectorXd::Constant(n, 2.0);
  a = a + b;
  a = a - b;
  a = 2.0 * b;
  a += b;
  a -= b;
  a -= 2.0 * b;
  a.segment(i, n) = b;
  a.segment(i, n) += b;
  a.head(n) = b.head(n);
  a.tail(n) = b.tail(n);
  a.segment<3>(i) = b.segment<3>(i);
  a = B.diagonal();
  a = B.diagonal().cwiseSqrt();
  a = B * b;
  a = B.transpose() * b;
  a += B * b;
  a -= B * b;
  a << b.head(n), b;
  const ConstRef whole(A), part(B.block(i, i, n, n)), columns(B.middleCols(i, n));
  const Eigen::Ref<Eigen::MatrixXd> written(A);
  const Eigen::Ref<const Eigen::VectorXd> column(b), piece(b.segment(i, n));
  a[0] = a.norm() + a.squaredNorm() + a.dot(b) + a.maxCoeff() + a.sum() + b.cwiseAbs().maxCoeff() +
         (a - b).norm() + A.norm() + A.cwiseAbs().maxCoeff() + (A - B).norm() + A.trace() + whole(0, 0) +
         part(0, 0) + columns(0, 0) + written(0, 0) + column[0] + piece[0] +
         (a.allFinite() && A.allFinite() ? 1.0 : 0.0);
}

/// Names all of the above for the sizes that occur: Eigen's own classes are compiled with it.
inline void all_of_them() {
  Eigen::Matrix3d R;
  Eigen::Vector3d p;
  of_poses(R, p, 1.0);
  Eigen::Matrix2d A2;
  Eigen::Vector2d a2;
  of_size<2>(A2, a2);
  Eigen::Matrix<double, 6, 6> A6;
  Eigen::Matrix<double, 6, 1> a6;
  of_size<6>(A6, a6);
  of_pieces<6>(a6, A6, 0);
  Eigen::MatrixXd A;
  Eigen::VectorXd a;
  of_any_size(A, a, 0, 3);
}

}  // namespace limber::precompiled
