// SPDX-License-Identifier: MIT
#include "limber/core/covariance.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "random_matrix.hpp"

namespace limber {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using testing::Generator;
using testing::random_index;
using testing::random_matrix;

constexpr Index kBody = 6;  // the leading block, which propagates and never leaves

MatrixXd random_symmetric(Generator& generator, Index n) {
  const MatrixXd A = random_matrix(generator, n, n);
  return A + A.transpose();
}

/// A few distinct triplets, in any order.
std::vector<Index> random_triplets(Generator& generator, Index n) {
  std::vector<Index> starts;
  for (Index start = 0; start < n; start += kTriplet) {
    starts.push_back(start);
  }
  std::shuffle(starts.begin(), starts.end(), generator);
  starts.resize(static_cast<std::size_t>(random_index(generator, 1, std::min<Index>(n / kTriplet, 4))));
  return starts;
}

std::vector<Index> columns_of(const std::vector<Index>& starts) {
  std::vector<Index> columns;
  for (const Index start : starts) {
    for (Index k = 0; k < kTriplet; ++k) {
      columns.push_back(start + k);
    }
  }
  return columns;
}

/// The obvious covariance: a full matrix, every operation written out.
class DenseTwin {
 public:
  MatrixXd P;

  void append(Index count) {
    const MatrixXd old = P;
    P = MatrixXd::Zero(old.rows() + count, old.rows() + count);
    P.topLeftCorner(old.rows(), old.rows()) = old;
  }

  void remove_triplet(Index start) {
    std::vector<Index> order;
    for (Index k = 0; k < P.rows(); ++k) {
      order.push_back(k);
    }
    for (Index k = 0; k < kTriplet; ++k) {
      order[static_cast<std::size_t>(start + k)] = P.rows() - kTriplet + k;
    }
    order.resize(order.size() - kTriplet);
    P = P(order, order).eval();
  }

  void propagate(const MatrixXd& Phi, const MatrixXd& Q) {
    MatrixXd F = MatrixXd::Identity(P.rows(), P.rows());
    F.topLeftCorner(Phi.rows(), Phi.rows()) = Phi;
    P = (F * P * F.transpose()).eval();
    P.topLeftCorner(Q.rows(), Q.rows()) += Q;
  }
};

/// A covariance and its twin, filled with the same symmetric matrix.
struct Pair {
  Covariance covariance;
  DenseTwin twin;

  Pair(Generator& generator, Index n) {
    covariance.append(n);
    twin.P = random_symmetric(generator, n);
    covariance.set_diagonal_block(0, twin.P);
  }

  void expect_equal(double tolerance = 0.0) const {
    ASSERT_EQ(covariance.size(), twin.P.rows());
    EXPECT_LE((covariance.dense() - twin.P).cwiseAbs().maxCoeff(), tolerance);
  }
};

TEST(Covariance, StartsEmptyAndGrowsByZeros) {
  Covariance P;
  EXPECT_EQ(P.size(), 0);
  EXPECT_EQ(P.append(6), 0);
  EXPECT_EQ(P.append(3), 6);
  EXPECT_EQ(P.size(), 9);
  EXPECT_TRUE(P.dense().isZero(0.0));
}

TEST(Covariance, AppendingKeepsWhatIsThereWhileCapacityGrows) {
  Generator generator(1);
  Pair pair(generator, kBody);
  for (int k = 0; k < 100; ++k) {
    EXPECT_EQ(pair.covariance.append(kTriplet), pair.twin.P.rows());
    pair.twin.append(kTriplet);
    const MatrixXd block = random_symmetric(generator, kTriplet);
    pair.covariance.set_diagonal_block(pair.covariance.size() - kTriplet, block);
    pair.twin.P.bottomRightCorner<3, 3>() = block;
    pair.expect_equal();
  }
}

TEST(Covariance, ACopyIsEqualAndOfItsOwn) {
  Generator generator(9);
  Pair pair(generator, kBody + 8 * kTriplet);
  Pair other(generator, kBody + 2 * kTriplet);
  Covariance& smaller = other.covariance;
  smaller = pair.covariance;  // has not got the room
  EXPECT_EQ(smaller.dense(), pair.covariance.dense());
  const MatrixXd before = smaller.dense();
  pair.covariance.subtract_outer(MatrixXd::Ones(pair.covariance.size(), 1));
  pair.covariance.append(kTriplet);
  EXPECT_EQ(smaller.dense(), before);
  pair.covariance = smaller;  // has it
  EXPECT_EQ(pair.covariance.dense(), before);
  const Covariance copy(smaller);
  EXPECT_EQ(copy.dense(), before);
}

TEST(Covariance, AppendingAfterRemovalStartsFromZeroAgain) {
  Generator generator(2);
  Pair pair(generator, 12);
  pair.covariance.remove_triplet(9);
  pair.covariance.append(kTriplet);
  EXPECT_TRUE(pair.covariance.block(9, 0, 3, 12).isZero(0.0));
}

TEST(Covariance, EveryAccessorReadsTheSymmetricMatrix) {
  Generator generator(3);
  const Pair pair(generator, 21);
  const MatrixXd& P = pair.twin.P;
  for (Index row = 0; row < 21; row += 2) {
    for (Index col = 0; col < 21; col += 3) {
      const Index rows = std::min<Index>(5, 21 - row);
      const Index cols = std::min<Index>(4, 21 - col);
      EXPECT_EQ(pair.covariance.block(row, col, rows, cols), P.block(row, col, rows, cols));
    }
  }
  EXPECT_EQ(pair.covariance.diagonal_block<6>(9), (P.block<6, 6>(9, 9)));
  for (Index row = 0; row < 21; row += 3) {
    for (Index col = 0; col < 21; col += 3) {
      EXPECT_EQ(pair.covariance.triplet_block(row, col), (P.block<3, 3>(row, col)));
    }
  }
}

TEST(Covariance, DiagonalBlockIsSetFromTheLowerTriangleAlone) {
  Generator generator(4);
  Pair pair(generator, 12);
  Eigen::Matrix3d value = random_symmetric(generator, 3);
  pair.twin.P.block<3, 3>(6, 6) = value;
  value.triangularView<Eigen::StrictlyUpper>().setConstant(1e9);
  pair.covariance.set_diagonal_block(6, value);
  pair.expect_equal();
}

TEST(Covariance, GatherPicksColumnsInTheOrderAskedFor) {
  Generator generator(5);
  const Pair pair(generator, 24);
  for (int k = 0; k < 20; ++k) {
    const std::vector<Index> starts = random_triplets(generator, 24);
    MatrixXd columns;
    pair.covariance.gather(starts, columns);
    EXPECT_EQ(columns, pair.twin.P(Eigen::all, columns_of(starts)));
  }
}

TEST(Covariance, ScatterUndoesGather) {
  Generator generator(6);
  Pair pair(generator, 24);
  for (int k = 0; k < 20; ++k) {
    const std::vector<Index> starts = random_triplets(generator, 24);
    MatrixXd columns;
    pair.covariance.gather(starts, columns);
    pair.covariance.scatter(starts, columns);
    pair.expect_equal();
  }
}

TEST(Covariance, AssignedValuesReplaceWhatWasThere) {
  Generator generator(21);
  Pair pair(generator, 30);
  for (const Index n : {12, 90, 30}) {
    pair.twin.P = random_symmetric(generator, n);
    pair.covariance.assign(pair.twin.P);
    pair.expect_equal();
    EXPECT_EQ(pair.covariance.append(3), n);
    pair.twin.append(3);
    pair.expect_equal();
  }
}

TEST(Covariance, ProductsAreThoseOfTheDenseMatrix) {
  Generator generator(22);
  for (const Index n : {12, 30, 90}) {
    Pair pair(generator, n);
    const MatrixXd X = random_matrix(generator, n, 5);
    EXPECT_LE((pair.covariance.times(X) - pair.twin.P * X).cwiseAbs().maxCoeff(), 1e-12);
    pair.covariance.add_outer(X);
    pair.twin.P += X * X.transpose();
    pair.expect_equal(1e-12);
  }
}

TEST(Covariance, PropagationMovesTheLeadingBlockAndItsCrossTerms) {
  Generator generator(7);
  for (const Index n : {kBody, Index{15}, Index{60}}) {
    Pair pair(generator, n);
    const MatrixXd Phi = random_matrix(generator, kBody, kBody);
    const MatrixXd Q = random_symmetric(generator, kBody);
    pair.covariance.propagate_leading(Phi, Q);
    pair.twin.propagate(Phi, Q);
    pair.expect_equal(1e-13);
  }
}

TEST(Covariance, CouplesTheLeadingBlockToATripletBehindIt) {
  Generator generator(10);
  for (const Index from : {kBody, Index{12}, Index{27}}) {
    Pair pair(generator, 30);
    const MatrixXd U = random_matrix(generator, kBody, kTriplet);
    pair.covariance.couple_leading(U, from);
    MatrixXd T = MatrixXd::Identity(30, 30);
    T.block(0, from, kBody, kTriplet) = U;
    pair.twin.P = (T * pair.twin.P * T.transpose()).eval();
    pair.expect_equal(1e-12);
  }
}

TEST(Covariance, CrossPropagationLeavesTheLeadingBlockAlone) {
  Generator generator(8);
  Pair pair(generator, 30);
  const MatrixXd Phi = random_matrix(generator, kBody, kBody);
  const MatrixXd leading = pair.twin.P.topLeftCorner(kBody, kBody);
  pair.covariance.propagate_cross(Phi);
  pair.twin.propagate(Phi, MatrixXd::Zero(kBody, kBody));
  pair.twin.P.topLeftCorner(kBody, kBody) = leading;
  pair.expect_equal(1e-13);
}

/// One random operation on both. @return what it was, for the message of a failure
std::string random_step(Generator& generator, Pair& pair) {
  Covariance& P = pair.covariance;
  MatrixXd& dense = pair.twin.P;
  switch (random_index(generator, 0, 7)) {
    case 0: {
      const Index count = kTriplet * random_index(generator, 1, 4);
      P.append(count);
      pair.twin.append(count);
      return "append";
    }
    case 1: {
      if (P.size() == kBody) {
        return "nothing";
      }
      const Index start = kTriplet * random_index(generator, kBody / kTriplet, P.size() / kTriplet - 1);
      EXPECT_EQ(P.remove_triplet(start), dense.rows() - kTriplet);
      pair.twin.remove_triplet(start);
      return "remove";
    }
    case 2: {
      const std::vector<Index> starts = random_triplets(generator, P.size());
      const std::vector<Index> places = columns_of(starts);
      MatrixXd columns = random_matrix(generator, P.size(), static_cast<Index>(places.size()));
      const MatrixXd meeting = columns(places, Eigen::all);
      columns(places, Eigen::all) = meeting + meeting.transpose();
      P.scatter(starts, columns);
      dense(Eigen::all, places) = columns;
      dense(places, Eigen::all) = columns.transpose();
      return "scatter";
    }
    case 3: {
      const MatrixXd W = 0.1 * random_matrix(generator, P.size(), random_index(generator, 1, 5));
      P.subtract_outer(W);
      dense -= W * W.transpose();
      return "subtract";
    }
    case 4: {
      const MatrixXd Phi = 0.4 * random_matrix(generator, kBody, kBody);
      const MatrixXd Q = random_symmetric(generator, kBody);
      P.propagate_leading(Phi, Q);
      pair.twin.propagate(Phi, Q);
      return "propagate";
    }
    case 5: {
      const Index k = random_index(generator, 1, 4);
      const MatrixXd U = 0.1 * random_matrix(generator, P.size(), k);
      const MatrixXd V = 0.1 * random_matrix(generator, P.size(), k);
      P.add_symmetric_product(U, V);
      dense += U * V.transpose() + V * U.transpose();
      return "add symmetric product";
    }
    case 6: {
      const Index start = kTriplet * random_index(generator, 0, P.size() / kTriplet - 1);
      const Eigen::Matrix3d M = 0.5 * random_matrix(generator, kTriplet, kTriplet);
      P.transform_triplet(start, M);
      MatrixXd T = MatrixXd::Identity(dense.rows(), dense.rows());
      T.block<3, 3>(start, start) = M;
      dense = (T * dense * T.transpose()).eval();
      return "transform";
    }
    default: {
      const Index start = kTriplet * random_index(generator, 0, P.size() / kTriplet - 1);
      const Eigen::Matrix3d value = random_symmetric(generator, kTriplet);
      P.set_diagonal_block(start, value);
      dense.block<3, 3>(start, start) = value;
      return "set";
    }
  }
}

TEST(Covariance, AgreesWithADenseMatrixOverRandomSequencesOfOperations) {
  for (std::uint64_t seed = 100; seed < 120; ++seed) {
    Generator generator(seed);
    Pair pair(generator, kBody);
    for (int k = 0; k < 200; ++k) {
      const std::string what = random_step(generator, pair);
      ASSERT_EQ(pair.covariance.size(), pair.twin.P.rows()) << what;
      ASSERT_LE((pair.covariance.dense() - pair.twin.P).cwiseAbs().maxCoeff(), 1e-11)
          << what << ", seed " << seed << ", operation " << k;
    }
  }
}

}  // namespace
}  // namespace limber
