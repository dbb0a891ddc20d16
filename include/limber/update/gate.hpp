// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

#include "limber/update/innovation.hpp"
#include "limber/update/update.hpp"

namespace limber {

/// Which groups of a measurement passed, and how far each was off.
struct GateReport {
  std::vector<bool> accepted;     ///< one flag per group
  std::vector<double> distance;   ///< squared Mahalanobis distance when judged last [-], one per group
  std::vector<double> threshold;  ///< what it was compared with [-], one per group
  std::vector<Eigen::Index> dof;  ///< degrees of freedom of the distance, one per group
  /// More than half of the groups failed: then the model is wrong, not the points, and none of them is
  /// refused but for gross outliers.
  bool overruled = false;
  /// Most groups were refused, and agree on nothing.
  bool most_mismatched = false;
  /// How far half of the groups are off, beside what the noise that is assumed lets expect [-], squared;
  /// before any is refused, and nothing where there are few.
  std::optional<double> scatter{};

  /// Whether more than half of the groups were refused.
  [[nodiscard]] bool most_refused() const;
  /// Whether no group was refused.
  [[nodiscard]] bool all_accepted() const;
};

/// Chi-square quantiles of one probability; those of a point's rows are computed once.
class GateThresholds {
 public:
  /// @param probability  chance that a good point passes, in (0, 1)
  explicit GateThresholds(double probability);

  /// What a squared distance of so many degrees of freedom may be; 0 for none.
  [[nodiscard]] double of(Eigen::Index dof) const { return share_ * threshold_.of(dof); }
  /// What half of all squared distances are below.
  [[nodiscard]] double median_of(Eigen::Index dof) const { return median_.of(dof); }
  /// The same, so many times as large.
  [[nodiscard]] GateThresholds times(double share) const;

 private:
  struct Quantiles {
    explicit Quantiles(double p);
    [[nodiscard]] double of(Eigen::Index dof) const;

    double probability;
    std::array<double, 5> of_point;  // by degrees of freedom
  };

  Quantiles threshold_, median_;
  double share_ = 1.0;
};

/// What is known of the pose that the groups were predicted with.
struct PredictedPose {
  /// For a while, by inputs without a fault: better than by most of the groups.
  bool known = false;
  /// m×6: how it moves the rows (FrameInnovation), where it is known to some pixels, as by an IMU; else
  /// empty.
  Eigen::MatrixXd by_pose{};
  /// 6×6: the covariance of its error, where nothing but the images tell how the body moved; else empty.
  Eigen::MatrixXd P{};
  /// c×k: how the parameters may be wrong before a point is called mismatched, beside P; may be empty.
  Eigen::MatrixXd rig{};
  /// GateReport::scatter as the frames before had it, where that is known. Something that begins to move puts
  /// half of the groups off at once.
  std::optional<double> usual_scatter{};
};

/// @brief Judges each group on its *projected* residual, so that a wrong calibration refuses no point.
///
/// With dtheta_hat = (DᵀS⁻¹D)⁺DᵀS⁻¹r, group i is judged on (r − D dtheta_hat)_i with the diagonal block of
/// S − D (DᵀS⁻¹D)⁺ Dᵀ; while the worst group exceeds the chi-square quantile it is dropped and all others are
/// judged anew. Judging each group on its own residual would throw away the right camera.
///
/// One gross outlier spoils dtheta_hat for all others. So where a group fails, those that lie far from what
/// most groups agree upon (find_consensus) go first, all at once, if they are less than half.
///
/// Where more than half fail, the model is wrong and none is refused, unless the prediction is known better
/// than that. Then thresholds are those of the noise that is assumed, but no more than twice what the
/// distance of half of the groups lets expect: that noise stands for what lasts in pixels, too, and is
/// several times what a frame shows. Something that begins to move would be within it, and take the state
/// along. Where half of the groups are farther off than usual, what is usual bounds that, if those that fail
/// then and the others are of no one rigid world, with any rig. Where five groups or more go on agreeing with
/// it, while no pose puts both them and the others where they are, there are two bodies, and the one that the
/// prediction knows is the world. And where it is known to some pixels, while no pose and no parameters put
/// half of the groups, and eight, near where they are, these are mismatched, and what agrees with the
/// prediction is kept, which may be nothing. Where nothing but the images tell of the motion, each is judged
/// after what the pose can explain of all, too: else whatever some motion explains would pass. A filter that
/// constrains nothing refuses those alone that are mismatched whatever the rig is; where most are off with
/// the rig as it is, the gate is overruled.
/// @param groups  partition of the rows of the innovation: of a measurement as it is, or turned
/// @note O(m³) for S⁻¹, then O(m²) for each group that is dropped and nothing for gross outliers.
[[nodiscard]] GateReport gate(const Innovation& innovation, const std::vector<RowGroup>& groups,
                              const ParameterErrorModel& model, const GateThresholds& thresholds,
                              const PredictedPose& predicted = {});

/// Groups further than this many times their threshold (in squared distance) from the consensus are gross
/// outliers.
inline constexpr double kGrossOutlier = 4.0;

}  // namespace limber
