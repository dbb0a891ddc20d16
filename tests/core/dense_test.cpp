// SPDX-License-Identifier: MIT
#include "limber/core/dense.hpp"

#include <gtest/gtest.h>

#include <random>

#include "check_covariance.hpp"
#include "limber/core/factors.hpp"

namespace limber {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kRounding = 1e-12;

MatrixXd some_matrix(testing::Generator& generator, Index rows, Index cols) {
  return testing::random_normal(generator, rows * cols).reshaped(rows, cols);
}

MatrixXd some_positive_definite(testing::Generator& generator, Index n) {
  const MatrixXd A = some_matrix(generator, n, n);
  return A * A.transpose() + MatrixXd::Identity(n, n);
}

double difference(const MatrixXd& A, const MatrixXd& B) {
  return A.rows() != B.rows() || A.cols() != B.cols() ? 1e300 : (A - B).lpNorm<Eigen::Infinity>();
}

/// A B, entry for entry.
MatrixXd obvious_product(const MatrixXd& A, const MatrixXd& B) {
  MatrixXd C = MatrixXd::Zero(A.rows(), B.cols());
  for (Index i = 0; i < A.rows(); ++i) {
    for (Index j = 0; j < B.cols(); ++j) {
      for (Index k = 0; k < A.cols(); ++k) {
        C(i, j) += A(i, k) * B(k, j);
      }
    }
  }
  return C;
}

TEST(Dense, ProductsAreThoseOfTheirEntriesWhateverTheShape) {
  testing::Generator generator(1);
  for (const Index m : {0, 1, 2, 7, 40}) {
    for (const Index n : {0, 1, 3, 25}) {
      for (const Index k : {0, 1, 5, 33}) {
        const MatrixXd A = some_matrix(generator, m, k), B = some_matrix(generator, k, n);
        const MatrixXd At = A.transpose(), Bt = B.transpose(), expected = obvious_product(A, B);
        EXPECT_LE(difference(multiply(A, B), expected), kRounding);
        EXPECT_LE(difference(multiply(transposed(At), B), expected), kRounding);
        EXPECT_LE(difference(multiply(A, transposed(Bt)), expected), kRounding);
        const MatrixXd C = some_matrix(generator, m, n);
        MatrixXd plain = C, left = C, right = C;
        add_product(plain, -2.0, A, B);
        add_product(left, -2.0, transposed(At), B);
        add_product(right, -2.0, A, transposed(Bt));
        for (const MatrixXd& sum : {plain, left, right}) {
          EXPECT_LE(difference(sum, C - 2.0 * expected), kRounding);
        }
      }
    }
  }
}

TEST(Dense, SymmetricProductsWriteTheLowerTriangleAlone) {
  testing::Generator generator(2);
  const MatrixXd A = some_matrix(generator, 9, 4), B = some_matrix(generator, 9, 4),
                 C = some_matrix(generator, 9, 9);
  const MatrixXd ABt = obvious_product(A, B.transpose()), AAt = obvious_product(A, A.transpose());
  MatrixXd expected = C, out = C;
  expected.triangularView<Eigen::Lower>() += ABt;
  add_lower_product(out, A, transposed(B));
  EXPECT_LE(difference(out, expected), kRounding);
  expected = out = C;
  expected.triangularView<Eigen::Lower>() += 3.0 * AAt;
  add_outer(out, 3.0, A);
  EXPECT_LE(difference(out, expected), kRounding);
  const MatrixXd U = symmetric_part(some_matrix(generator, 4, 4));
  EXPECT_EQ(U, U.transpose());
  EXPECT_LE(difference(congruence(A, U), obvious_product(obvious_product(A, U), A.transpose())), kRounding);
  EXPECT_LE(difference(congruence(transposed(A), C), obvious_product(obvious_product(A.transpose(), C), A)),
            10.0 * kRounding);
}

TEST(Dense, BlocksAreTakenInTheirPlace) {
  testing::Generator generator(3);
  MatrixXd big = some_matrix(generator, 12, 12);
  const MatrixXd before = big;
  add_product(big.block(2, 3, 4, 5), 1.0, before.block(0, 0, 4, 6), before.block(6, 1, 6, 5));
  MatrixXd expected = before;
  expected.block(2, 3, 4, 5) += obvious_product(before.block(0, 0, 4, 6), before.block(6, 1, 6, 5));
  EXPECT_LE(difference(big, expected), kRounding);
}

TEST(Dense, TriangularSolvesUndoTheProduct) {
  testing::Generator generator(4);
  for (const Index n : {1, 4, 11, 40}) {
    const MatrixXd noisy =
        some_matrix(generator, n, n) / static_cast<double>(n) + 3.0 * MatrixXd::Identity(n, n);
    const MatrixXd L = noisy.triangularView<Eigen::Lower>();
    const MatrixXd X = some_matrix(generator, n, 6), Xt = X.transpose();
    MatrixXd out = L * X;
    solve_lower(noisy, out);
    EXPECT_LE(difference(out, X), kRounding);
    out = L.transpose() * X;
    solve_lower(transposed(noisy), out);
    EXPECT_LE(difference(out, X), kRounding);
    out = Xt * L;
    solve_lower_from_right(noisy, out);
    EXPECT_LE(difference(out, Xt), kRounding);
    out = Xt * L.transpose();
    solve_lower_from_right(transposed(noisy), out);
    EXPECT_LE(difference(out, Xt), kRounding);
    VectorXd x = L * X.col(0), longer(n + 2);
    longer << 1.0, x, 2.0;
    solve_lower(noisy, x);
    solve_lower(noisy, longer.segment(1, n));
    EXPECT_LE(difference(x, X.col(0)), kRounding);
    EXPECT_LE(difference(longer.segment(1, n), X.col(0)), kRounding);
    EXPECT_EQ(longer(0) + longer(n + 1), 3.0);
  }
  MatrixXd none(3, 0);
  solve_lower(MatrixXd::Identity(3, 3), none);
  EXPECT_EQ(none.rows(), 3);
}

TEST(Factors, CholeskyFactorsSolvesAndRefuses) {
  testing::Generator generator(5);
  for (const Index n : {1, 4, 40}) {
    const MatrixXd A = some_positive_definite(generator, n), B = some_matrix(generator, n, 3);
    const Cholesky cholesky(A);
    ASSERT_TRUE(cholesky.succeeded());
    EXPECT_LE(difference(cholesky.L() * cholesky.L().transpose(), A), 1e-10);
    EXPECT_LE(difference(A * cholesky.solve(B), B), 1e-10);
    EXPECT_LE(difference(A * cholesky.solve(B.col(0)), B.col(0)), 1e-10);
    EXPECT_LE(difference(A * cholesky.inverse(), MatrixXd::Identity(n, n)), 1e-10);
    EXPECT_LE(difference(A * solve_symmetric(A, B.col(1)), B.col(1)), 1e-10);
    EXPECT_FALSE(Cholesky(-A).succeeded());
  }
}

TEST(Factors, TheRootOfASemidefiniteMatrixRebuildsIt) {
  testing::Generator generator(7);
  const MatrixXd A = some_positive_definite(generator, 9);
  const MatrixXd singular = A.leftCols(4) * A.leftCols(4).transpose();
  for (const MatrixXd& S : {A, singular}) {
    const MatrixXd V = semidefinite_root(S);
    EXPECT_LE(difference(V * V.transpose(), S), 1e-11 * S.norm());
  }
}

TEST(Factors, SymmetricEigenRebuildsTheMatrix) {
  testing::Generator generator(6);
  const MatrixXd A = some_positive_definite(generator, 8);
  const SymmetricEigen eigen = symmetric_eigen(A);
  EXPECT_LE(difference(eigen.vectors * eigen.values.asDiagonal() * eigen.vectors.transpose(), A), 1e-11);
  EXPECT_LE(eigen.values(0), eigen.values(7));
}

TEST(Factors, ReflectionsRebuildTheMatrix) {
  testing::Generator generator(7);
  for (const auto& [m, n] : {std::pair<Index, Index>{9, 4}, {4, 9}, {5, 5}, {3, 1}}) {
    const MatrixXd A = some_matrix(generator, m, n);
    const HouseholderQr qr = householder_qr(A);
    const MatrixXd Q = qr.Q();
    EXPECT_LE(difference(Q.transpose() * Q, MatrixXd::Identity(m, m)), kRounding);
    EXPECT_LE(difference(Q.leftCols(qr.R().rows()) * qr.R(), A), kRounding);
    MatrixXd turned = A;
    qr.apply_Qt(turned);
    EXPECT_LE(difference(turned, Q.transpose() * A), kRounding);
    VectorXd x = A.col(0);
    qr.apply_Qt(x);
    EXPECT_LE(difference(x, turned.col(0)), kRounding);
  }
}

TEST(Factors, PivotsFindTheRankAndTheRowsAreThoseOfTheMatrix) {
  testing::Generator generator(8);
  const MatrixXd A = some_matrix(generator, 9, 3) * some_matrix(generator, 3, 5);
  const PivotedQr pivoted = pivoted_qr(A);
  EXPECT_EQ(pivoted.rank, 3);
  EXPECT_LE(difference(pivoted.qr.Q().leftCols(3) * pivoted.turned_rows(3), A), 1e-11);
  EXPECT_NEAR(pivoted.largest_pivot, A.colwise().norm().maxCoeff(), 1e-11);
}

TEST(Factors, SingularVectorsAndPseudoInverseAreThoseOfTheMatrix) {
  testing::Generator generator(9);
  const MatrixXd A = some_matrix(generator, 7, 2) * some_matrix(generator, 2, 4);
  const RightSingular svd = right_singular(A);
  ASSERT_EQ(svd.values.size(), 4);
  EXPECT_LE(difference((A * svd.V).colwise().norm().transpose(), svd.values), 1e-11);
  EXPECT_LE(difference(svd.V.transpose() * svd.V, MatrixXd::Identity(4, 4)), kRounding);
  const VectorXd b = testing::random_normal(generator, 7);
  const PseudoInverse pseudo = pseudo_inverse(A, b);
  EXPECT_LE(difference(A * pseudo.matrix * A, A), 1e-11);
  EXPECT_LE(difference(pseudo.matrix * A * pseudo.matrix, pseudo.matrix), 1e-11);
  EXPECT_LE(difference(pseudo.matrix * b, pseudo.x), 1e-11);
  EXPECT_EQ(pseudo_inverse(A), pseudo.matrix);
}

}  // namespace
}  // namespace limber
