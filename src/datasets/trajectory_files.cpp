// SPDX-License-Identifier: MIT
#include "limber/datasets/trajectory_files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "formats.hpp"
#include "io/numbers.hpp"
#include "io/table_text.hpp"
#include "io/text_file.hpp"
#include "limber/core/errors.hpp"
#include "limber/io/atomic_file.hpp"

namespace limber {
namespace {

using detail::TableReader;
using detail::TableText;

constexpr std::size_t kCsvColumns = 47, kCsvColumnsOfOld = 38;  // before there were sigmas
constexpr double kLargestPosition = 1e30;                       // [m]; its powers still are numbers
constexpr std::array<const char*, 17> kCsvStateColumns = {
    "t_ns",        "px [m]",      "py [m]",      "pz [m]",      "qw [-]",     "qx [-]",
    "qy [-]",      "qz [-]",      "vx [m/s]",    "vy [m/s]",    "vz [m/s]",   "bgx [rad/s]",
    "bgy [rad/s]", "bgz [rad/s]", "bax [m/s^2]", "bay [m/s^2]", "baz [m/s^2]"};

// Names and units of all columns of trajectory.csv.
std::vector<std::string> csv_columns() {
  constexpr std::array<const char*, 6> kErrors = {"px", "py", "pz", "rx", "ry", "rz"};
  std::vector<std::string> names(kCsvStateColumns.begin(), kCsvStateColumns.end());
  for (std::size_t i = 0; i < 6; ++i) {
    for (std::size_t j = i; j < 6; ++j) {
      const char* const unit = j < 3 ? "m^2" : i < 3 ? "m rad" : "rad^2";
      names.push_back(fmt::format("P_{}_{} [{}]", kErrors[i], kErrors[j], unit));
    }
  }
  for (std::size_t k = 8; k < kCsvStateColumns.size(); ++k) {
    names.push_back(fmt::format("sigma_{}", kCsvStateColumns[k]));
  }
  return names;
}

std::string first_name(std::string_view column) { return std::string(column.substr(0, column.find(' '))); }

bool is_csv_header(std::string_view line) { return line.starts_with("t_ns,") || line.starts_with("#t_ns,"); }

// The columns first .. first+count-1 are all empty: unknown. Some of them: an error.
bool unknown(const TableReader& table, std::size_t first, std::size_t count) {
  std::size_t empty = 0;
  for (std::size_t k = first; k < first + count; ++k) {
    empty += table.field(k).empty() ? 1 : 0;
  }
  if (empty != 0 && empty != count) {
    table.fail(fmt::format("columns {} to {} all filled or all empty", first + 1, first + count),
               fmt::format("{} of {} empty", empty, count));
  }
  return empty == count;
}

std::optional<Eigen::Vector3d> optional_vector3(const TableReader& table, std::size_t first) {
  return unknown(table, first, 3) ? std::nullopt : std::optional<Eigen::Vector3d>(table.vector3(first));
}

std::optional<Eigen::Vector3d> optional_sigma(const TableReader& table, std::size_t first) {
  const std::optional<Eigen::Vector3d> sigma = optional_vector3(table, first);
  if (sigma && sigma->minCoeff() < 0.0) {
    table.fail("standard deviations that are not negative", fmt::format("{}", sigma->minCoeff()));
  }
  return sigma;
}

std::optional<Eigen::Matrix<double, 6, 6>> optional_covariance(const TableReader& table, std::size_t first) {
  if (unknown(table, first, 21)) {
    return std::nullopt;
  }
  Eigen::Matrix<double, 6, 6> P;
  for (Eigen::Index i = 0; i < 6; ++i) {
    for (Eigen::Index j = i; j < 6; ++j) {
      P(i, j) = P(j, i) = table.number(first++);
    }
  }
  return P;
}

void add_covariance(TableText& table, const Eigen::Matrix<double, 6, 6>& P) {
  for (Eigen::Index i = 0; i < 6; ++i) {
    for (Eigen::Index j = i; j < 6; ++j) {
      table.cell(P(i, j));
    }
  }
}

void add_optional(TableText& table, const std::optional<Eigen::Vector3d>& v) {
  v ? table.cells(*v) : table.empty_cells(3);
}

// The first line that is not blank, and the first that is not a comment either.
struct FirstLines {
  std::string any, data;
};

FirstLines first_lines(const std::filesystem::path& path) {
  const std::string text = detail::load_text(path);
  FirstLines first;
  for (std::size_t begin = 0; begin < text.size() && first.data.empty();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    const std::string line = text.substr(begin, end - begin);
    if (line.find_first_not_of(" \t\r") != std::string::npos) {
      first.any = first.any.empty() ? line : first.any;
      first.data = line.starts_with('#') ? "" : line;
    }
    begin = end + 1;
  }
  return first;
}

std::size_t count_words(std::string_view line) {
  std::size_t words = 0;
  bool in_word = false;
  for (const char c : line) {
    const bool blank = c == ' ' || c == '\t' || c == '\r';
    words += !blank && !in_word ? 1 : 0;
    in_word = !blank;
  }
  return words;
}

TrajectoryFormat recognise(const std::filesystem::path& path) {
  const FirstLines first = first_lines(path);
  if (is_csv_header(first.any)) {
    return TrajectoryFormat::kLimber;
  }
  if (first.data.find(',') != std::string::npos) {
    return TrajectoryFormat::kEurocGroundTruth;
  }
  switch (count_words(first.data)) {
    case 12:
      return TrajectoryFormat::kKittiPoses;
    case 8:
    case 14:
    case 20:
      return TrajectoryFormat::kTum;
    default:
      throw DataError(
          path.string(), 0,
          "a trajectory: TUM (8 columns), KITTI poses (12 columns), EuRoC ground truth (8, 11 or 17 "
          "columns with commas) or limber's trajectory.csv (header t_ns,...)",
          first.data.empty() ? "no line of data" : detail::excerpt(first.data));
  }
}

template <typename State, typename ToPose>
std::vector<StampedPose> stamped_poses(const std::vector<State>& states, ToPose to_pose) {
  std::vector<StampedPose> poses;
  poses.reserve(states.size());
  for (const State& state : states) {
    poses.push_back({state.t_ns, to_pose(state)});
  }
  return poses;
}

}  // namespace

std::vector<StampedPose> poses_of(const std::vector<TrajectoryRow>& rows) {
  return stamped_poses(rows, [](const TrajectoryRow& row) { return row.T_world_body; });
}

std::vector<StampedPose> poses_of(const std::vector<GroundTruthState>& states) {
  return stamped_poses(states, [](const GroundTruthState& s) {
    return Pose{s.R_world_body, s.p_world_body};
  });
}

Trajectory read_trajectory(const std::filesystem::path& path) {
  const TrajectoryFormat format = recognise(path);
  switch (format) {
    case TrajectoryFormat::kTum:
      return {format, true, read_tum(path)};
    case TrajectoryFormat::kKittiPoses:
      return {format, false, read_kitti_poses(path)};
    case TrajectoryFormat::kEurocGroundTruth:
      return {format, true, poses_of(read_euroc_groundtruth(path).states)};
    case TrajectoryFormat::kLimber:
      break;
  }
  return {format, true, poses_of(read_trajectory_csv(path))};
}

std::vector<StampedPose> read_tum(const std::filesystem::path& path) {
  TableReader table(path, {.separator = ' ',
                           .names = {"t [s]", "tx [m]", "ty [m]", "tz [m]", "qx", "qy", "qz", "qw"},
                           .counts = {8, 14, 20}});
  std::vector<StampedPose> poses;
  while (table.next()) {
    const auto t_ns = detail::parse_seconds_as_ns(table.field(0));
    if (!t_ns) {
      table.fail("a time in seconds", detail::excerpt(table.field(0)));
    }
    table.require_later(*t_ns);
    const Eigen::Vector4d wxyz(table.number(7), table.number(4), table.number(5), table.number(6));
    poses.push_back({*t_ns, {table.rotation(wxyz), table.vector3(1, kLargestPosition)}});
  }
  table.require_a_row("pose");
  return poses;
}

void write_tum(const std::filesystem::path& path, const std::vector<StampedPose>& poses) {
  TableText table("write_tum", ' ');
  table.header("# t[s] tx ty tz qx qy qz qw");
  for (const StampedPose& pose : poses) {
    table.require_later(pose.t_ns);
    table.cell(std::string_view(detail::format_ns_as_seconds(pose.t_ns)));
    table.cells(pose.T_world_body.p);
    const Eigen::Vector4d wxyz = detail::quaternion_wxyz(pose.T_world_body.R);
    table.cells(wxyz.tail<3>());
    table.cell(wxyz[0]);
    table.end_row();
  }
  write_file_atomically(path, table.text());
}

std::vector<StampedPose> read_kitti_poses(const std::filesystem::path& path) {
  TableReader table(path, {.separator = ' ', .names = {"the upper 3x4 of a pose"}, .counts = {12}});
  const Pose T_zup_kitti{detail::R_zup_kitti(), Eigen::Vector3d::Zero()};
  std::vector<StampedPose> poses;
  while (table.next()) {
    Eigen::Matrix<double, 3, 4> T;
    for (Eigen::Index k = 0; k < 12; ++k) {
      T(k / 4, k % 4) = table.number(static_cast<std::size_t>(k), kLargestPosition);
    }
    if (!detail::checked_rotation(T.leftCols<3>())) {
      table.fail("a pose with a rotation in its left 3x3 block", "a matrix that is none");
    }
    poses.push_back({static_cast<std::int64_t>(poses.size()), T_zup_kitti * Pose{T.leftCols<3>(), T.col(3)}});
  }
  table.require_a_row("pose");
  return poses;
}

void write_kitti_poses(const std::filesystem::path& path, const std::vector<StampedPose>& poses) {
  const Pose T_kitti_zup{detail::R_zup_kitti().transpose(), Eigen::Vector3d::Zero()};
  TableText table("write_kitti_poses", ' ');
  for (const StampedPose& pose : poses) {
    const Pose T = T_kitti_zup * pose.T_world_body;
    for (Eigen::Index row = 0; row < 3; ++row) {
      table.cells(T.R.row(row));
      table.cell(T.p(row));
    }
    table.end_row();
  }
  write_file_atomically(path, table.text());
}

GroundTruth read_euroc_groundtruth(const std::filesystem::path& path) {
  TableReader table(path, {.names = {"timestamp [ns]", "p_x", "p_y", "p_z", "q_w", "q_x", "q_y", "q_z", "v_x",
                                     "v_y", "v_z", "b_w_x", "b_w_y", "b_w_z", "b_a_x", "b_a_y", "b_a_z"},
                           .counts = {8, 11, 17}});
  GroundTruth truth;
  while (table.next()) {
    truth.has_velocity = table.columns() >= 11;
    truth.has_biases = table.columns() == 17;
    GroundTruthState state;
    state.t_ns = table.increasing_time();
    state.p_world_body = table.vector3(1, kLargestPosition);
    state.R_world_body = table.rotation({table.number(4), table.number(5), table.number(6), table.number(7)});
    if (truth.has_velocity) {
      state.v_world_body = table.vector3(8);
    }
    if (truth.has_biases) {
      state.bias_gyro = table.vector3(11);
      state.bias_accel = table.vector3(14);
    }
    truth.states.push_back(state);
  }
  table.require_a_row("ground truth sample");
  return truth;
}

std::vector<TrajectoryRow> read_trajectory_csv(const std::filesystem::path& path) {
  if (!is_csv_header(first_lines(path).any)) {
    throw DataError(path.string(), 1, "the header of a trajectory.csv (t_ns,px [m],...)",
                    "another first line");
  }
  const auto names = csv_columns();
  TableReader table(path, {.names = {names.begin(), names.end()}, .counts = {kCsvColumnsOfOld, kCsvColumns}});
  std::vector<TrajectoryRow> rows;
  while (table.next()) {
    if (table.field(0) == "t_ns") {
      for (std::size_t k = 0; k < table.columns(); ++k) {
        if (first_name(table.field(k)) != first_name(names[k])) {
          table.fail(fmt::format("{} as name of column {}", names[k], k + 1),
                     detail::excerpt(table.field(k)));
        }
      }
      continue;
    }
    TrajectoryRow row;
    row.t_ns = table.increasing_time();
    row.T_world_body.p = table.vector3(1, kLargestPosition);
    row.T_world_body.R = table.rotation({table.number(4), table.number(5), table.number(6), table.number(7)});
    row.v_world_body = optional_vector3(table, 8);
    row.bias_gyro = optional_vector3(table, 11);
    row.bias_accel = optional_vector3(table, 14);
    row.covariance = optional_covariance(table, 17);
    if (table.columns() == kCsvColumns) {
      row.sigma_v = optional_sigma(table, 38);
      row.sigma_bias_gyro = optional_sigma(table, 41);
      row.sigma_bias_accel = optional_sigma(table, 44);
    }
    rows.push_back(row);
  }
  if (rows.empty()) {
    throw DataError(path.string(), 0, "at least one pose", "none: the file has no data");
  }
  return rows;
}

void write_trajectory_csv(const std::filesystem::path& path, const std::vector<TrajectoryRow>& rows) {
  TableText table("write_trajectory_csv", ',');
  for (const std::string& name : csv_columns()) {
    table.cell(std::string_view(name));
  }
  table.end_row();
  for (const TrajectoryRow& row : rows) {
    table.time(row.t_ns);
    table.cells(row.T_world_body.p);
    table.cells(detail::quaternion_wxyz(row.T_world_body.R));
    add_optional(table, row.v_world_body);
    add_optional(table, row.bias_gyro);
    add_optional(table, row.bias_accel);
    row.covariance ? add_covariance(table, *row.covariance) : table.empty_cells(21);
    add_optional(table, row.sigma_v);
    add_optional(table, row.sigma_bias_gyro);
    add_optional(table, row.sigma_bias_accel);
    table.end_row();
  }
  write_file_atomically(path, table.text());
}

}  // namespace limber
