// SPDX-License-Identifier: MIT
#include "limber/core/settling_matrix.hpp"

#include <gtest/gtest.h>

#include <string>

#include "random_matrix.hpp"

namespace limber {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using testing::Generator;
using testing::random_index;
using testing::random_matrix;
using testing::random_triplet;

/// One random operation on both. @return what it was, for the message of a failure
std::string random_step(Generator& generator, SettlingMatrix& M, MatrixXd& at_once) {
  const Index rows = M.rows(), cols = M.cols();
  const int step = cols < 9 || rows < 9 ? 0 : static_cast<int>(random_index(generator, 0, 9));
  const Index row = step > 0 ? random_triplet(generator, rows) : 0;
  const Index col = step > 0 ? random_triplet(generator, cols) : 0;
  const Matrix3d C = 0.5 * random_matrix(generator, kTriplet, kTriplet);
  switch (step) {
    case 0: {
      const Index l = random_index(generator, 1, 20), n = 30, m = 24;
      const MatrixXd S = random_matrix(generator, m, n), A = random_matrix(generator, m, l),
                     B = 0.2 * random_matrix(generator, l, n);
      M.assign_in_shares(S, A, B, random_index(generator, 1, 8));
      at_once = S + A * B;
      return "assign";
    }
    case 1: {
      const MatrixXd left = 0.2 * random_matrix(generator, kTriplet, rows);
      M.add_to_rows(row, left);
      at_once.middleRows<kTriplet>(row) += (left * at_once).eval();
      return "add to rows";
    }
    case 2: {
      const Index from = random_triplet(generator, rows);
      M.couple_rows(row, from, C);
      at_once.middleRows<kTriplet>(row) += (C * at_once.middleRows<kTriplet>(from)).eval();
      return "couple rows";
    }
    case 3: {
      M.transform_rows(row, C);
      at_once.middleRows<kTriplet>(row) = (C * at_once.middleRows<kTriplet>(row)).eval();
      return "transform rows";
    }
    case 4: {
      const MatrixXd A = random_matrix(generator, rows - kTriplet, 3),
                     B = 0.2 * random_matrix(generator, 3, cols);
      M.add_product_above(-1.0, A, B);
      at_once.topRows(A.rows()) -= A * B;
      return "add product above";
    }
    case 5: {
      M.add_block(row, col, C);
      at_once.block<kTriplet, kTriplet>(row, col) += C;
      return "add block";
    }
    case 6: {
      M.transform_triplet(col, C);
      at_once.middleCols<kTriplet>(col) = (at_once.middleCols<kTriplet>(col) * C).eval();
      return "transform triplet";
    }
    case 7: {
      const MatrixXd more = random_matrix(generator, kTriplet, cols);
      M.append_rows(more);
      at_once.conservativeResize(rows + kTriplet, Eigen::NoChange);
      at_once.bottomRows<kTriplet>() = more;
      return "append rows";
    }
    case 8: {
      M.remove_triplet(col);
      at_once.middleCols<kTriplet>(col) = at_once.rightCols<kTriplet>().eval();
      at_once.conservativeResize(Eigen::NoChange, cols - kTriplet);
      return "remove";
    }
    default: {
      M.settle();
      return "settle";
    }
  }
}

TEST(SettlingMatrix, IsAtEveryMomentWhatItWouldBeHadAllBeenAddedAtOnce) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Generator generator(seed);
    SettlingMatrix M;
    MatrixXd at_once;
    for (int k = 0; k < 100; ++k) {
      const std::string what = random_step(generator, M, at_once);
      ASSERT_EQ(M.rows(), at_once.rows()) << what;
      ASSERT_EQ(M.cols(), at_once.cols()) << what;
      const double tolerance = 1e-12 * (1.0 + at_once.cwiseAbs().maxCoeff());
      ASSERT_LE((M.dense() - at_once).cwiseAbs().maxCoeff(), tolerance) << what << ", seed " << seed;
      const Index col = random_triplet(generator, M.cols());
      ASSERT_LE((M.triplet(col) - at_once.middleCols<kTriplet>(col)).cwiseAbs().maxCoeff(), tolerance)
          << what;
      const Eigen::VectorXd x = random_matrix(generator, M.rows(), 1);
      ASSERT_LE((M.transposed_times(x) - at_once.transpose() * x).norm(), 100.0 * tolerance) << what;
    }
  }
}

TEST(SettlingMatrix, HasAddedEverythingAfterItsShares) {
  Generator generator(3);
  SettlingMatrix M;
  const MatrixXd S = random_matrix(generator, 24, 30), A = random_matrix(generator, 24, 11),
                 B = random_matrix(generator, 11, 30);
  M.assign_in_shares(S, A, B, 4);
  for (int k = 0; k < 4; ++k) {
    M.settle();
  }
  SettlingMatrix settled = M;
  settled.settle_all();
  EXPECT_EQ(M.dense(), settled.dense());  // to the bit: nothing waits
  EXPECT_LE((M.dense() - (S + A * B)).norm(), 1e-11);
}

}  // namespace
}  // namespace limber
