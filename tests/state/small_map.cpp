// SPDX-License-Identifier: MIT
#include "state/small_map.hpp"

#include <algorithm>
#include <random>

#include "limber/core/factors.hpp"

namespace limber::testing {

Eigen::MatrixXd random_positive_definite(Generator& generator, Eigen::Index n, double sigma) {
  std::normal_distribution<double> draw;
  const Eigen::MatrixXd W = Eigen::MatrixXd::NullaryExpr(n, n, [&] { return draw(generator); });
  return sigma * sigma * (W * W.transpose() / static_cast<double>(n) + 0.2 * Eigen::MatrixXd::Identity(n, n));
}

StateLayout with_supposed_steps() {
  StateLayout layout{MotionModel::kImu};
  layout.has_supposed_steps = true;
  return layout;
}

Estimate random_estimate(Generator& generator, StateLayout layout) {
  NavigationState nav;
  nav.T_world_body = random_pose(generator, 5.0);
  nav.v_world_body = random_vector(generator, 1.0);
  RigParameters theta;
  theta << 0.01, -0.02, 0.03, -0.5, 0.01, -0.01;
  const Eigen::Matrix<double, 6, 6> P_theta = random_positive_definite(generator, 6, 1e-3);
  return {layout, nav, random_positive_definite(generator, layout.body_size(), 0.01), theta, P_theta};
}

void add_random_landmark(Generator& generator, Estimate& estimate, std::int64_t track_id, int anchor) {
  Landmark landmark;
  landmark.track_id = track_id;
  landmark.last_seen_ns = track_id;
  if (anchor >= 0) {
    landmark.kind = LandmarkKind::kInverseDepth;
    landmark.anchor = anchor;
    landmark.R_cam0_chart = random_rotation(generator, 0.4);
    landmark.value << 0.1 * random_vector(generator, 1.0).head<2>(), random_scalar(generator, 0.1, 0.5);
  } else {
    landmark.kind = LandmarkKind::kCartesian;
    landmark.value = random_vector(generator, 10.0);
  }
  std::normal_distribution<double> draw;
  const Eigen::MatrixXd P = estimate.P().dense();
  const Eigen::MatrixXd G = Eigen::MatrixXd::NullaryExpr(3, P.rows(), [&] { return 0.3 * draw(generator); });
  estimate.add_landmark(landmark, congruence(G, P) + random_positive_definite(generator, 3, 0.01),
                        P * G.transpose());
}

Estimate empty_map() {
  return {{MotionModel::kOdometry, false},
          {},
          1e-6 * Eigen::MatrixXd::Identity(6, 6),
          RigParameters::Zero(),
          Eigen::Matrix<double, 6, 6>::Identity()};
}

void add_landmark_ahead(Estimate& estimate, std::int64_t track_id, double depth, double sigma_rho,
                        std::int64_t seen_ns) {
  Landmark landmark;
  landmark.track_id = track_id;
  landmark.anchor = estimate.add_anchor({});
  landmark.value << 0.0, 0.0, 1.0 / depth;
  landmark.last_seen_ns = seen_ns;
  Eigen::Matrix3d P = 1e-6 * Eigen::Matrix3d::Identity();
  P(2, 2) = sigma_rho * sigma_rho;
  estimate.add_landmark(landmark, P);
}

Estimate random_map(Generator& generator, int count, StateLayout layout) {
  Estimate estimate = random_estimate(generator, layout);
  int anchor = -1;
  for (int k = 0; k < count; ++k) {
    if (k % 4 == 0) {
      move_body(estimate, [&](NavigationState& nav) { nav.T_world_body = random_pose(generator, 5.0); });
      anchor = estimate.add_anchor(random_pose(generator, 0.2));
    }
    add_random_landmark(generator, estimate, k, k % 4 == 3 ? -1 : anchor);
  }
  return estimate;
}

Eigen::MatrixXd gauge(const Estimate& estimate) {
  Eigen::MatrixXd N = Eigen::MatrixXd::Zero(estimate.size(), 6);
  const auto vector = [&](Eigen::Index at, const Eigen::Vector3d& x, bool moves) {
    N.block<3, 3>(at, 0) = -skew(x);
    if (moves) {
      N.block<3, 3>(at, 3).setIdentity();
    }
  };
  const auto pose = [&](Eigen::Index position, Eigen::Index attitude, const Pose& T) {
    vector(position, T.p, true);
    N.block<3, 3>(attitude, 0) = T.R.transpose();
  };
  pose(0, 3, estimate.nav().T_world_body);
  if (estimate.layout().motion != MotionModel::kOdometry) {
    vector(6, estimate.nav().v_world_body, false);
  }
  for (const Landmark& landmark : estimate.landmarks()) {
    if (const Anchor* anchor = estimate.anchor_of(landmark); anchor != nullptr) {
      pose(anchor->position_at, anchor->attitude_at, anchor->T_world_body);
    } else {
      vector(landmark.at, landmark.value, true);
    }
  }
  return N;
}

bool Snapshot::operator==(const Snapshot& other) const {
  return track_ids == other.track_ids && mean.size() == other.mean.size() && mean == other.mean &&
         P.rows() == other.P.rows() && P == other.P;
}

Eigen::MatrixXd awake_covariance(const Estimate& estimate) {
  const Eigen::Index body = estimate.layout().map_begin();
  std::vector<Eigen::Index> places;
  for (Eigen::Index k = 0; k < estimate.size(); ++k) {
    if (k < body || k >= 2 * body || !estimate.has_frozen()) {
      places.push_back(k);
    }
  }
  return estimate.P().dense()(places, places);
}

Snapshot snapshot(const Estimate& estimate, const std::vector<std::int64_t>& without) {
  std::vector<const Landmark*> landmarks;
  for (const Landmark& landmark : estimate.landmarks()) {
    if (std::find(without.begin(), without.end(), landmark.track_id) == without.end()) {
      landmarks.push_back(&landmark);
    }
  }
  std::sort(landmarks.begin(), landmarks.end(),
            [](const Landmark* a, const Landmark* b) { return a->track_id < b->track_id; });
  std::vector<Eigen::Index> places;
  std::vector<double> mean;
  const auto place = [&](Eigen::Index at, Eigen::Index size) {
    for (Eigen::Index k = 0; k < size; ++k) {
      places.push_back(at + k);
    }
  };
  const auto value = [&](const Eigen::MatrixXd& x) {
    mean.insert(mean.end(), x.data(), x.data() + x.size());
  };
  place(0, estimate.layout().map_begin());
  value(estimate.nav().T_world_body.R);
  value(estimate.nav().T_world_body.p);
  value(estimate.nav().v_world_body);
  value(estimate.nav().bias_gyro);
  value(estimate.nav().bias_accel);
  value(estimate.theta());
  Snapshot out;
  for (const Landmark* landmark : landmarks) {
    out.track_ids.push_back(landmark->track_id);
    place(landmark->at, 3);
    value(landmark->value);
    if (const Anchor* anchor = estimate.anchor_of(*landmark); anchor != nullptr) {
      place(anchor->position_at, 3);
      place(anchor->attitude_at, 3);
      value(anchor->T_world_body.R);
      value(anchor->T_world_body.p);
    }
  }
  out.mean = Eigen::Map<const Eigen::VectorXd>(mean.data(), static_cast<Eigen::Index>(mean.size()));
  out.P = estimate.P().dense()(places, places);
  return out;
}

}  // namespace limber::testing
