// SPDX-License-Identifier: MIT
#include "limber/run_files/health_state.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "io/json_text.hpp"
#include "io/text_file.hpp"
#include "limber/core/errors.hpp"
#include "limber/io/atomic_file.hpp"

namespace limber {
namespace {

using Json = nlohmann::ordered_json;
using Matrix = NormalEquations::Matrix;

constexpr int kVersion = 1;

std::string in_words(const Distortion& distortion) {
  const auto k = coefficients(distortion);
  return k.empty() ? "no distortion" : fmt::format("{} {}", model_name(distortion), fmt::join(k, " "));
}

template <typename Derived>
Json numbers(const Eigen::MatrixBase<Derived>& matrix) {
  Json out = Json::array();
  for (Eigen::Index row = 0; row < matrix.rows(); ++row) {
    for (Eigen::Index column = 0; column < matrix.cols(); ++column) {
      out.push_back(matrix(row, column));
    }
  }
  return out;
}

/// The parts of a file, with errors that name it.
class StateReader {
 public:
  StateReader(const std::string& text, const std::string& name)
      : path_(name), json_(detail::parse_json<Json>(text, name)) {
    if (!json_.is_object() || !json_.contains("limber_health_state")) {
      throw DataError(path_, 0, "a health_state.json that limber health wrote", "other JSON");
    }
    if (whole("limber_health_state") != kVersion) {
      throw DataError(path_, 0, fmt::format("limber_health_state {}", kVersion), "another version");
    }
  }

  [[nodiscard]] std::string text(const Json& value, const char* what) const {
    if (!value.is_string()) {
      throw DataError(path_, 0, fmt::format("text at '{}'", what), value.dump());
    }
    return value.get<std::string>();
  }
  [[nodiscard]] std::string text(const char* key) const { return text(at(key), key); }

  [[nodiscard]] std::int64_t whole(const char* key) const {
    const Json& value = at(key);
    if (!value.is_number_integer() || value.get<std::int64_t>() < 0) {
      throw DataError(path_, 0, fmt::format("a whole number from 0 at '{}'", key), value.dump());
    }
    return value.get<std::int64_t>();
  }
  [[nodiscard]] std::size_t count(const char* key) const { return static_cast<std::size_t>(whole(key)); }

  /// Files of older versions lack some.
  [[nodiscard]] bool has(const char* key) const { return json_.contains(key); }

  [[nodiscard]] bool flag(const char* key) const {
    if (!at(key).is_boolean()) {
      throw DataError(path_, 0, fmt::format("true or false at '{}'", key), at(key).dump());
    }
    return at(key).get<bool>();
  }

  template <int kRows, int kColumns>
  [[nodiscard]] Eigen::Matrix<double, kRows, kColumns> matrix(const char* key) const {
    const Json& values = at(key);
    Eigen::Matrix<double, kRows, kColumns> out;
    if (!values.is_array() || values.size() != static_cast<std::size_t>(out.size())) {
      throw DataError(path_, 0, fmt::format("{} numbers at '{}'", out.size(), key),
                      values.is_array() ? fmt::format("{}", values.size()) : values.dump());
    }
    for (std::size_t k = 0; k < values.size(); ++k) {
      if (!values[k].is_number() || !std::isfinite(values[k].get<double>())) {
        throw DataError(path_, 0, fmt::format("numbers at '{}'", key), values[k].dump());
      }
      const auto i = static_cast<Eigen::Index>(k);
      out(i / kColumns, i % kColumns) = values[k].get<double>();
    }
    return out;
  }

  [[nodiscard]] Matrix square(const char* key) const {
    Matrix out = matrix<NormalEquations::kSize, NormalEquations::kSize>(key);
    if (!(out.diagonal().minCoeff() >= 0.0) || !out.isApprox(out.transpose(), 1e-9)) {
      throw DataError(path_, 0, fmt::format("a symmetric matrix with no negative diagonal at '{}'", key),
                      "another");
    }
    return out;
  }

  [[nodiscard]] const Json& at(const char* key) const {
    if (!json_.contains(key)) {
      throw DataError(path_, 0, fmt::format("the key '{}'", key), "none");
    }
    return json_.at(key);
  }

 private:
  std::string path_;
  Json json_;
};

}  // namespace

std::string camera_in_words(const Camera& camera) {
  return fmt::format("{}x{} px, {} {} {} {}, {}", camera.width, camera.height, camera.fu, camera.fv,
                     camera.cu, camera.cv, in_words(camera.distortion));
}

std::string to_json(const HealthState& state) {
  const RigRecord& rig = state.rig;
  const Json json = {{"limber_health_state", kVersion},
                     {"recording", state.recording},
                     {"cameras", state.cameras},
                     {"theta", numbers(rig.theta.transpose())},
                     {"metric", rig.metric},
                     {"from_ns", rig.from_ns},
                     {"to_ns", rig.to_ns},
                     {"windows", rig.windows},
                     {"tracks", rig.tracks},
                     {"points", rig.points},
                     {"points_with_depth", rig.deep},
                     {"tracks_with_depth", rig.deep_tracks},
                     {"beta", numbers(rig.estimate.beta.transpose())},
                     {"covariance", numbers(rig.estimate.covariance)},
                     {"epipolar", numbers(rig.estimate.epipolar)}};
  return detail::json_text(json, 1) + "\n";
}

HealthState parse_health_state(const std::string& text, const std::string& name) {
  const StateReader in(text, name);
  HealthState out;
  out.recording = in.text("recording");
  const Json& cameras = in.at("cameras");
  for (std::size_t k = 0; k < 2; ++k) {
    out.cameras[k] = in.text(cameras.is_array() && cameras.size() == 2 ? cameras[k] : Json(), "cameras");
  }
  out.rig.theta = in.matrix<6, 1>("theta");
  out.rig.metric = in.flag("metric");
  out.rig.from_ns = in.whole("from_ns");
  out.rig.to_ns = in.whole("to_ns");
  out.rig.windows = in.count("windows");
  out.rig.tracks = in.count("tracks");
  out.rig.points = in.count("points");
  out.rig.deep = in.count("points_with_depth");
  out.rig.deep_tracks = in.has("tracks_with_depth") ? in.count("tracks_with_depth") : out.rig.tracks;
  out.rig.estimate.beta = in.matrix<NormalEquations::kSize, 1>("beta");
  out.rig.estimate.covariance = in.square("covariance");
  out.rig.estimate.epipolar = in.square("epipolar");
  return out;
}

void write_health_state(const std::filesystem::path& path, const HealthState& state) {
  write_file_atomically(path, to_json(state));
}

std::filesystem::path health_state_file(const std::filesystem::path& path) {
  return std::filesystem::is_directory(path) ? path / kHealthStateName : path;
}

HealthState read_health_state(const std::filesystem::path& path) {
  const std::filesystem::path file = health_state_file(path);
  return parse_health_state(detail::load_text(file), file.string());
}

}  // namespace limber
