// SPDX-License-Identifier: MIT
#include "limber/core/settling_covariance.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "random_matrix.hpp"

namespace limber {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using testing::Generator;
using testing::random_index;
using testing::random_matrix;
using testing::random_triplet;

/// One random operation on both. @return what it was, for the message of a failure
std::string random_step(Generator& generator, SettlingCovariance& P, Covariance& at_once) {
  const Index n = P.size();
  const Index start = n > 0 ? random_triplet(generator, n) : 0;
  switch (n < 9 ? 0 : random_index(generator, 0, 5)) {
    case 0: {
      EXPECT_EQ(P.append(12), n);
      at_once.append(12);
      return "append";
    }
    case 1: {
      const Index k = random_index(generator, 1, 20), m = random_index(generator, 1, 9);
      const MatrixXd R = random_matrix(generator, k, m), G = 0.3 * random_matrix(generator, m, n);
      P.add_in_shares(R, G, random_index(generator, 1, 8));
      at_once.add_outer((R * G).transpose());
      return "add in shares";
    }
    case 2: {
      EXPECT_EQ(P.remove_triplet(start), n - kTriplet);
      at_once.remove_triplet(start);
      return "remove";
    }
    case 3: {
      const Eigen::Matrix3d M = 0.5 * random_matrix(generator, kTriplet, kTriplet);
      P.transform_triplet(start, M);
      at_once.transform_triplet(start, M);
      return "transform";
    }
    case 4: {
      const MatrixXd W = 0.3 * random_matrix(generator, n, 3);
      P.subtract_outer(W);
      at_once.subtract_outer(W);
      return "subtract";
    }
    default: {
      P.settle();
      return "settle";
    }
  }
}

TEST(SettlingCovariance, IsAtEveryMomentWhatItWouldBeHadAllBeenAddedAtOnce) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Generator generator(seed);
    SettlingCovariance P;
    Covariance at_once;
    for (int k = 0; k < 100; ++k) {
      const std::string what = random_step(generator, P, at_once);
      ASSERT_EQ(P.size(), at_once.size()) << what;
      ASSERT_LE((P.dense() - at_once.dense()).cwiseAbs().maxCoeff(), 1e-11) << what << ", seed " << seed;
      const Index row = random_triplet(generator, P.size());
      const Index col = random_triplet(generator, P.size());
      ASSERT_LE((P.triplet_block(row, col) - at_once.triplet_block(row, col)).norm(), 1e-11) << what;
      const std::vector<Index> both = {row, col};
      MatrixXd columns, expected;
      P.gather(both, columns);
      at_once.gather(both, expected);
      ASSERT_LE((columns - expected).norm(), 1e-11) << what;
    }
  }
}

TEST(SettlingCovariance, HasAddedEverythingAfterItsShares) {
  Generator generator(3);
  SettlingCovariance P;
  P.append(30);
  const MatrixXd R = random_matrix(generator, 11, 7), G = random_matrix(generator, 7, 30);
  P.add_in_shares(R, G, 4);
  for (int k = 0; k < 4; ++k) {
    P.settle();
  }
  SettlingCovariance settled = P;
  settled.settle_all();
  EXPECT_EQ(P.dense(), settled.dense());  // to the bit: nothing waits
  EXPECT_LE((P.dense() - (R * G).transpose() * (R * G)).norm(), 1e-11);
}

}  // namespace
}  // namespace limber
