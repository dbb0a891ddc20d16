// SPDX-License-Identifier: MIT
#pragma once

#include "limber/study/run_figures.hpp"

namespace limber::detail {

/// @brief Calls visit(name, member) for every figure, in the order of tables. Names that start with "ms_" are
/// timings.
/// @param figures RunFigures, const or not
template <typename Figures, typename Visit>
void visit_figures(Figures& figures, Visit visit) {
  visit("position_rmse_m", figures.position_rmse_m);
  visit("attitude_rmse_deg", figures.attitude_rmse_deg);
  visit("position_final_m", figures.position_final_m);
  visit("attitude_final_deg", figures.attitude_final_deg);
  visit("position_max_m", figures.position_max_m);
  visit("attitude_max_deg", figures.attitude_max_deg);
  visit("landmark_rmse_m", figures.landmark_rmse_m);
  visit("ate_none_m", figures.ate_none_m);
  visit("ate_se3_m", figures.ate_se3_m);
  visit("ate_sim3_m", figures.ate_sim3_m);
  visit("scale", figures.scale);
  visit("anees", figures.anees);
  visit("anees_position", figures.anees_position);
  visit("anees_attitude", figures.anees_attitude);
  visit("anees_scale", figures.anees_scale);
  visit("share_within_95", figures.share_within_95);
  visit("frames_refused", figures.frames_refused);
  visit("nis", figures.nis);
  visit("nis_dof", figures.nis_dof);
  visit("path_length_m", figures.path_length_m);
  visit("points_per_frame", figures.points_per_frame);
  visit("frames", figures.frames);
  visit("points_refused", figures.points_refused);
  visit("start_s", figures.start_s);
  visit("lost_s", figures.lost_s);
  visit("ms_per_frame_mean", figures.ms_per_frame_mean);
  visit("ms_per_frame_p50", figures.ms_per_frame_p50);
  visit("ms_per_frame_p99", figures.ms_per_frame_p99);
}

}  // namespace limber::detail
