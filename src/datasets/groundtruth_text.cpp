// SPDX-License-Identifier: MIT
#include "groundtruth_text.hpp"

#include "io/numbers.hpp"
#include "io/table_text.hpp"
#include "limber/io/atomic_file.hpp"

namespace limber {
namespace detail {

std::string groundtruth_text(const GroundTruth& truth) {
  const bool velocity = truth.has_velocity || truth.has_biases;
  std::string header =
      "#timestamp [ns],p_RS_R_x [m],p_RS_R_y [m],p_RS_R_z [m],q_RS_w [],q_RS_x [],q_RS_y [],q_RS_z []";
  header += velocity ? ",v_RS_R_x [m s^-1],v_RS_R_y [m s^-1],v_RS_R_z [m s^-1]" : "";
  header += truth.has_biases
                ? ",b_w_RS_S_x [rad s^-1],b_w_RS_S_y [rad s^-1],b_w_RS_S_z [rad s^-1],b_a_RS_S_x [m s^-2],"
                  "b_a_RS_S_y [m s^-2],b_a_RS_S_z [m s^-2]"
                : "";
  TableText table("ground truth", ',');
  table.header(header);
  for (const GroundTruthState& state : truth.states) {
    table.time(state.t_ns);
    table.cells(state.p_world_body);
    table.cells(quaternion_wxyz(state.R_world_body));
    if (velocity) {
      table.cells(state.v_world_body);
    }
    if (truth.has_biases) {
      table.cells(state.bias_gyro);
      table.cells(state.bias_accel);
    }
    table.end_row();
  }
  return std::string(table.text());
}

}  // namespace detail

void write_euroc_groundtruth(const std::filesystem::path& path, const GroundTruth& truth) {
  write_file_atomically(path, detail::groundtruth_text(truth));
}

}  // namespace limber
