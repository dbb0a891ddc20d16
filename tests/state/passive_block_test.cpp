// SPDX-License-Identifier: MIT
#include "limber/state/passive_block.hpp"
#include "limber/core/factors.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "random_matrix.hpp"
#include "small_map.hpp"

/// The passive block against its slow twin: one dense mean and covariance of everything, in which nobody
/// sleeps.
namespace limber {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using testing::Generator;
using testing::random_matrix;
using testing::random_positive_definite;

constexpr Index kBody = 6;

/// Triplets have names, 0, 1, ...; the twin holds triplet `name` at kBody + 3 name for ever.
class Pair {
 public:
  explicit Pair(int triplets)
      : dense_(random_positive_definite(generator_, kBody + 3 * triplets, 1.0)),
        mean_(VectorXd::Zero(dense_.rows())),
        body_mean_(VectorXd::Zero(kBody)),
        triplet_mean_(static_cast<std::size_t>(triplets), Eigen::Vector3d::Zero()) {
    P_.append(dense_.rows());
    P_.set_diagonal_block(0, dense_);
    for (int name = 0; name < triplets; ++name) {
      active_.push_back(name);
    }
  }

  /// A measurement of everything active, body included, and a step of the body.
  void live() {
    block_.settle();
    const Index rows = 4;
    MatrixXd H_active = random_matrix(generator_, rows, P_.size());
    H_active.middleCols(kBody, clones()).setZero();
    MatrixXd H = MatrixXd::Zero(rows, dense_.rows());
    H.leftCols(kBody) = H_active.leftCols(kBody);
    for (std::size_t k = 0; k < active_.size(); ++k) {
      H.middleCols<3>(place(active_[k])) = H_active.middleCols<3>(start(k));
    }
    const VectorXd innovation = random_matrix(generator_, rows, 1);
    const VectorXd dx =
        correct(P_.dense(), H_active, innovation, [&](const MatrixXd& W) { P_.subtract_outer(W); });
    mean_ += correct(dense_, H, innovation, [&](const MatrixXd& W) { dense_ -= W * W.transpose(); });
    body_mean_ += dx.head(kBody);
    for (std::size_t k = 0; k < active_.size(); ++k) {
      triplet_mean_[static_cast<std::size_t>(active_[k])] += dx.segment<3>(start(k));
    }
    drift_ += dx.segment(kBody, block_.z_size());

    const MatrixXd Phi = MatrixXd::Identity(kBody, kBody) + 0.1 * random_matrix(generator_, kBody, kBody);
    const MatrixXd Q = random_positive_definite(generator_, kBody, 0.1);
    P_.propagate_leading(Phi, Q);
    MatrixXd F = MatrixXd::Identity(dense_.rows(), dense_.rows());
    F.topLeftCorner(kBody, kBody) = Phi;
    dense_ = congruence(F, dense_);
    dense_.topLeftCorner(kBody, kBody) += Q;
  }

  /// A new landmark that the rest of its epoch is not frozen.
  void add_landmark() {
    const MatrixXd G = 0.3 * random_matrix(generator_, 3, kBody);
    const Matrix3d own = random_positive_definite(generator_, 3, 0.5);
    const auto cross = [&](const MatrixXd& P) { return MatrixXd(P.leftCols(kBody) * G.transpose()); };
    const MatrixXd in_active = cross(P_.dense()), in_dense = cross(dense_);
    const Matrix3d P_ll = G * dense_.topLeftCorner(kBody, kBody) * G.transpose() + own;
    const Index at = P_.append(3), end = dense_.rows();
    MatrixXd columns(P_.size(), 3);
    columns << in_active, P_ll;
    P_.scatter(std::vector<Index>{at}, columns);
    MatrixXd grown(end + 3, end + 3);
    grown << dense_, in_dense, in_dense.transpose(), P_ll;
    dense_ = grown;
    mean_.conservativeResize(end + 3);
    mean_.tail<3>().setZero();
    active_.push_back(static_cast<int>(triplet_mean_.size()));
    triplet_mean_.push_back(Eigen::Vector3d::Zero());
  }

  /// Everybody active rests with probability `rest`.
  void change_epoch(double rest) {
    EpochChange change;
    for (Index at = kBody; at < kBody + clones(); at += 3) {
      change.dropped.push_back(at);
    }
    std::vector<int> kept, passive = passive_;
    const VectorXd corrections = block_.correction(drift_);
    for (std::size_t k = 0; k < passive_.size(); ++k) {
      triplet_mean_[static_cast<std::size_t>(passive_[k])] +=
          corrections.segment<3>(3 * static_cast<Index>(k));
    }
    for (std::size_t k = 0; k < active_.size(); ++k) {
      const bool rests = testing::random_scalar(generator_, 0.0, 1.0) < rest;
      (rests ? change.retired : change.kept).push_back(start(k));
      (rests ? passive : kept).push_back(active_[k]);
    }
    ASSERT_TRUE(block_.change_epoch(P_, kBody, change));
    active_ = kept;
    passive_ = passive;
    frozen_ = block_.z_size() > 0 ? kept.size() : 0;
    drift_.setZero(block_.z_size());
  }

  /// Everybody passive is recalled with probability `wake`, at any time in an epoch.
  void recall(double wake) {
    std::vector<Index> rows;
    for (std::size_t k = 0; k < passive_.size(); ++k) {
      if (testing::random_scalar(generator_, 0.0, 1.0) < wake) {
        rows.push_back(3 * static_cast<Index>(k));
      }
    }
    if (rows.empty()) {
      return;
    }
    std::shuffle(rows.begin(), rows.end(), generator_);
    for (const Index row : rows) {
      const int woken = passive_[static_cast<std::size_t>(row / 3)];
      const Eigen::Vector3d correction = block_.correction(row, drift_.head(block_.z_size()));
      triplet_mean_[static_cast<std::size_t>(woken)] += correction;
      drift_.conservativeResize(drift_.size() + 3);
      drift_.tail<3>() = correction;
      active_.push_back(
          woken);  // behind the frozen ones, in the place of a new landmark, who goes to the end
      std::swap(active_[frozen_++], active_.back());
    }
    block_.recall(P_, kBody, rows);
    std::sort(rows.rbegin(), rows.rend());
    for (const Index row : rows) {
      passive_[static_cast<std::size_t>(row / 3)] = passive_.back();
      passive_.pop_back();
    }
  }

  /// Says the same of other coordinates: at the beginning of an epoch, for both twins.
  void change_coordinates() {
    if (block_.empty() || active_.size() < 2 || drift_.size() == 0) {
      return;
    }
    const Matrix3d M = Matrix3d::Identity() + 0.3 * random_matrix(generator_, 3, 3);
    const Matrix3d C = random_matrix(generator_, 3, 3);
    MatrixXd T = MatrixXd::Identity(dense_.rows(), dense_.rows());
    // An active triplet: transformed, then coupled to another.
    T.block<3, 3>(place(active_[0]), place(active_[0])) = M;
    T.block<3, 3>(place(active_[0]), place(active_[1])) = C;
    MatrixXd T_active = MatrixXd::Identity(P_.size(), P_.size());
    T_active.block<3, 3>(start(0), start(0)) = M;
    T_active.block<3, 3>(start(0), start(1)) = C;
    block_.transform_column(start(0) - kBody, M);
    block_.couple_column(start(0) - kBody, start(1) - kBody, C);
    // A passive one: transformed, then coupled to the body as it is now.
    T.block<3, 3>(place(passive_[0]), place(passive_[0])) = M;
    T.block<3, 3>(place(passive_[0]), 3) = C;
    block_.transform_row(0, M);
    block_.couple_row(0, 3, C);
    dense_ = congruence(T, dense_);
    mean_ = (T * mean_).eval();
    const MatrixXd P = congruence(T_active, P_.dense());
    P_.set_diagonal_block(0, P);
    for (const int name : {active_[0], passive_[0]}) {
      triplet_mean_[static_cast<std::size_t>(name)] = mean_.segment<3>(place(name));
    }
  }

  void forget_a_sleeper() {
    if (passive_.empty()) {
      return;
    }
    const auto k = static_cast<std::size_t>(testing::random_scalar(generator_, 0.0, 1.0) *
                                            static_cast<double>(passive_.size()));
    EXPECT_EQ(block_.remove(3 * static_cast<Index>(k)), 3 * static_cast<Index>(passive_.size() - 1));
    passive_[k] = passive_.back();
    passive_.pop_back();
  }

  /// Every block and mean, passive ones too.
  void expect_equal(const std::string& what) const {
    const double tolerance = 1e-9 * dense_.diagonal().maxCoeff();
    EXPECT_LE((P_.block(0, 0, kBody, kBody) - dense_.topLeftCorner(kBody, kBody)).norm(), tolerance) << what;
    EXPECT_LE((body_mean_ - mean_.head(kBody)).norm(), 1e-9 * (1.0 + mean_.norm())) << what;
    for (std::size_t i = 0; i < active_.size() + passive_.size(); ++i) {
      const Eigen::Vector3d expected = mean_.segment<3>(place(name(i)));
      EXPECT_LE((mean(i) - expected).norm(), 1e-9 * (1.0 + mean_.norm())) << what << ", triplet " << name(i);
      for (std::size_t j = 0; j <= i; ++j) {
        const Matrix3d twin = dense_.block<3, 3>(place(name(i)), place(name(j)));
        EXPECT_LE((covariance(i, j) - twin).norm(), tolerance) << what << ", " << name(i) << ", " << name(j);
      }
    }
  }

  [[nodiscard]] std::size_t passive() const { return passive_.size(); }
  [[nodiscard]] Index active_size() const { return P_.size(); }

 private:
  template <typename Subtract>
  static VectorXd correct(const MatrixXd& P, const MatrixXd& H, const VectorXd& innovation,
                          Subtract subtract) {
    const MatrixXd PHt = P * H.transpose();
    const Eigen::LLT<MatrixXd> S(H * PHt + MatrixXd::Identity(H.rows(), H.rows()));
    const MatrixXd W = S.matrixL().solve(PHt.transpose()).transpose();
    subtract(W);
    return PHt * S.solve(innovation);
  }

  static Index place(int name) { return kBody + 3 * name; }
  [[nodiscard]] Index clones() const { return block_.z_size() > 0 ? kBody : 0; }
  [[nodiscard]] Index start(std::size_t k) const { return kBody + clones() + 3 * static_cast<Index>(k); }
  [[nodiscard]] int name(std::size_t k) const {
    return k < active_.size() ? active_[k] : passive_[k - active_.size()];
  }
  [[nodiscard]] Index row(std::size_t k) const { return 3 * static_cast<Index>(k - active_.size()); }
  [[nodiscard]] Eigen::Vector3d mean(std::size_t k) const {
    const Eigen::Vector3d stored = triplet_mean_[static_cast<std::size_t>(name(k))];
    return k < active_.size() ? stored : Eigen::Vector3d(stored + block_.correction(row(k), drift_));
  }
  [[nodiscard]] Matrix3d covariance(std::size_t i, std::size_t j) const {
    if (i < active_.size()) {
      return P_.triplet_block(start(i), start(j));
    }
    return j < active_.size() ? Matrix3d(block_.cross(P_, kBody, row(i)).middleCols<3>(start(j)))
                              : block_.triplet_block(P_, kBody, row(i), row(j));
  }

  Generator generator_{11};
  MatrixXd dense_;
  VectorXd mean_;
  Covariance P_;
  PassiveBlock block_;
  VectorXd body_mean_, drift_;
  std::vector<Eigen::Vector3d> triplet_mean_;
  std::vector<int> active_, passive_;
  std::size_t frozen_ = 0;  // of the active ones, those that are part of z
};

TEST(PassiveBlock, IsTheFullFilterThroughManyEpochs) {
  Pair pair(12);
  std::size_t slept = 0;
  for (int epoch = 0; epoch < 12; ++epoch) {
    for (int frame = 0; frame < 3; ++frame) {
      pair.live();
      if (frame == 1) {
        pair.add_landmark();
        pair.add_landmark();
        pair.recall(0.25);
        pair.expect_equal("recalled amidst epoch " + std::to_string(epoch));
      }
    }
    pair.expect_equal("before epoch " + std::to_string(epoch));
    pair.change_epoch(0.4);
    if (epoch % 2 == 0) {
      pair.recall(0.3);
    }
    pair.expect_equal("after epoch " + std::to_string(epoch));
    pair.change_coordinates();
    pair.expect_equal("in other coordinates, epoch " + std::to_string(epoch));
    if (epoch % 3 == 2) {
      pair.forget_a_sleeper();
      pair.expect_equal("without one passive, epoch " + std::to_string(epoch));
    }
    slept += pair.passive();
  }
  EXPECT_GE(slept, 50U);
}

TEST(PassiveBlock, NobodyAsleepLeavesNoTrace) {
  Pair pair(4);
  pair.live();
  pair.change_epoch(0.0);
  EXPECT_EQ(pair.active_size(), kBody + 12);
  pair.change_epoch(1.0);
  EXPECT_EQ(pair.active_size(), 2 * kBody);
  pair.live();
  pair.recall(1.0);
  pair.live();
  pair.expect_equal("all recalled");
  pair.change_epoch(0.0);
  EXPECT_EQ(pair.active_size(), kBody + 12);
  pair.expect_equal("the clone is gone");
}

TEST(PassiveBlock, CopesWithATripletThatOthersDetermine) {
  // Two passive whose remainders are the same but for rounding: recalling one leaves nothing of the other's.
  Generator generator(3);
  const MatrixXd A = random_positive_definite(generator, kBody + 3, 1.0);
  MatrixXd copy(kBody + 6, kBody + 3);
  copy << MatrixXd::Identity(kBody + 3, kBody + 3), MatrixXd::Zero(3, kBody), Matrix3d::Identity();
  Covariance P;
  P.append(kBody + 6);
  P.set_diagonal_block(0, congruence(copy, A));
  PassiveBlock block;
  ASSERT_TRUE(block.change_epoch(P, kBody, {{}, {kBody, kBody + 3}, {}}));
  block.recall(P, kBody, std::vector<Index>{0});
  const Matrix3d expected = A.bottomRightCorner<3, 3>();
  EXPECT_LE((block.triplet_block(P, kBody, 0, 0) - expected).norm(), 1e-12);
  EXPECT_LE((P.diagonal_block<3>(2 * kBody) - expected).norm(), 1e-12);
  EXPECT_LE((block.cross(P, kBody, 0).middleCols<3>(2 * kBody) - expected).norm(), 1e-12);
}

/// A filter that is lost by hundreds of metres, and knows a point beside its pose to less than a micrometre.
TEST(PassiveBlock, CopesWithAnEigenvalueThatRoundingTookBelowZero) {
  Covariance P;
  P.append(kBody + 6);
  MatrixXd dense = MatrixXd::Identity(kBody + 6, kBody + 6);
  for (const Index i : {Index{0}, kBody}) {
    for (const Index j : {Index{0}, kBody}) {
      dense(i, j) = 350.0 * 350.0;
    }
  }
  dense(0, 0) *= 1.0 - 1e-13;
  P.set_diagonal_block(0, dense);
  PassiveBlock block;
  ASSERT_TRUE(block.change_epoch(P, kBody, {{kBody}, {kBody + 3}, {}}));
  EXPECT_NEAR(P.dense()(0, 0), 350.0 * 350.0, 1e-4);
}

TEST(PassiveBlock, RefusesACovarianceThatIsNone) {
  Covariance P;
  P.append(kBody + 6);
  const MatrixXd negative = -MatrixXd::Identity(kBody + 6, kBody + 6);
  P.set_diagonal_block(0, negative);
  PassiveBlock block;
  EXPECT_FALSE(block.change_epoch(P, kBody, {{kBody}, {kBody + 3}, {}}));
  EXPECT_TRUE(block.empty());
  EXPECT_EQ(P.dense(), negative);
}

}  // namespace
}  // namespace limber
