// SPDX-License-Identifier: MIT
#include "encode.hpp"

#include <fmt/format.h>

#include <limits>
#include <nlohmann/json.hpp>

#include "io/base64.hpp"
#include "io/json_text.hpp"
#include "limber/core/angle.hpp"
#include "limber/core/errors.hpp"
#include "limber/diagnose/health_summary.hpp"
#include "limber/health/normal_equations.hpp"

namespace limber::detail {
namespace {

using Json = nlohmann::ordered_json;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

template <typename Vector>
Json list_of(const Vector& values, double unit = 1.0) {
  Json out = Json::array();
  for (const double value : values) {
    out.push_back(unit * value);
  }
  return out;
}

Json json_of(const Pose& pose) {
  const Eigen::Quaterniond q(pose.R);
  return {{"p", list_of(pose.p)}, {"q", {q.w(), q.x(), q.y(), q.z()}}};
}

/// Resolution and field of view, as far as they are known.
Json json_of(const Camera& camera) {
  return {{"width", camera.width}, {"height", camera.height}, {"fu", camera.fu},
          {"fv", camera.fv},       {"cu", camera.cu},         {"cv", camera.cv}};
}

Json json_of(const std::vector<ViewPoint>& points) {
  std::vector<float> pixels;  // u0 v0 u1 v1 of each
  pixels.reserve(4 * points.size());
  Json ids = Json::array();
  std::string fates;
  for (const ViewPoint& point : points) {
    const StereoObservation& seen = point.seen;
    for (const auto& [uv, is_seen] :
         {std::pair(seen.uv_cam0, seen.in_cam0), std::pair(seen.uv_cam1, seen.in_cam1)}) {
      pixels.push_back(is_seen ? static_cast<float>(uv.x()) : kNan);
      pixels.push_back(is_seen ? static_cast<float>(uv.y()) : kNan);
    }
    ids.push_back(seen.track_id);
    fates += "uro"[static_cast<std::size_t>(point.fate)];
  }
  return {{"ids", ids}, {"fates", fates}, {"uv", to_base64(std::span<const float>(pixels))}};
}

Json json_of(const std::vector<ViewLandmark>& map) {
  std::vector<float> positions;
  positions.reserve(3 * map.size());
  Json ids = Json::array();
  for (const ViewLandmark& landmark : map) {
    ids.push_back(landmark.track_id);
    for (const double value : landmark.p_world) {
      positions.push_back(static_cast<float>(value));
    }
  }
  return {{"ids", ids}, {"p", to_base64(std::span<const float>(positions))}};
}

/// Images that cannot be read are no reason to stop: the status says so.
void put_images(const ViewFrame& frame, Json& out) {
  out["images"] = nullptr;
  if (!frame.images) return;
  try {
    const ViewImages images = frame.images();
    if (images[0].empty() || images[1].empty()) return;
    out["images"] = {to_base64(std::span(images[0])), to_base64(std::span(images[1]))};
  } catch (const DataError& error) {
    out["status"] = frame.status + "; no images: " + error.what();
  }
}

Json json_of(const HealthSummary& health, const WatchOptions& watch) {
  Json out = Json::parse(limber::to_json(health, watch));
  out["words"] = in_words(health, watch.tolerance);
  return out;
}

}  // namespace

std::string to_json(const ViewRun& run) {
  const StereoCalibration& calibration = run.calibration;
  Json axes = Json::array();
  for (std::size_t k = 0; k < 6; ++k) {
    axes.push_back(
        {{"name", kParameterNames[k]}, {"words", axis_in_words(k, vergence_axis(calibration.theta))}});
  }
  return detail::json_text(Json{{"title", run.title},
                                {"method", run.method},
                                {"frames", run.frames},
                                {"cameras", {json_of(calibration.cam0), json_of(calibration.cam1)}},
                                {"T_body_cam0", json_of(calibration.T_body_cam0)},
                                {"T_cam0_cam1", json_of(pose_from_rig(calibration.theta).inverse())},
                                {"axes", axes}});
}

std::string to_json(const ViewFrame& frame, const WatchOptions& watch) {
  Json out = {{"n", frame.number}, {"t", frame.t_s}};
  out.update(json_of(frame.T_world_body));
  if (frame.v_world_body) {
    out["v"] = list_of(*frame.v_world_body);
  }
  if (frame.sigma) {
    out["sigma_m"] = list_of(frame.sigma->head<3>());
    out["sigma_deg"] = list_of(frame.sigma->tail<3>(), kToDegrees);
  }
  out["status"] = frame.status;
  out["waiting"] = frame.waiting;
  out["points"] = json_of(frame.points);
  out["map"] = json_of(frame.map);
  out["stages"] = Json::array();
  for (const ViewStage& stage : frame.stages) {
    out["stages"].push_back({stage.name, stage.ms});
  }
  out["health"] = frame.health ? json_of(*frame.health, watch) : Json(nullptr);
  put_images(frame, out);
  return detail::json_text(out);
}

std::string json_string(const std::string& text) { return detail::json_text(Json(text)); }

std::string server_sent_event(std::string_view name, std::string_view data) {
  return fmt::format("event: {}\ndata: {}\n\n", name, data);
}

const std::string& EncodedFrame::event(const WatchOptions& watch) {
  std::call_once(once_, [&] {
    event_ = fmt::format("id: {}\n", sequence) + server_sent_event("frame", to_json(frame, watch));
  });
  return event_;
}

}  // namespace limber::detail
