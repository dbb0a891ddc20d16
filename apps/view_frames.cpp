// SPDX-License-Identifier: MIT
#include "view_frames.hpp"

#include <algorithm>
#include <mutex>
#include <unordered_set>

#include "limber/core/time.hpp"
#include "limber/frontend/encode_jpeg.hpp"
#include "pair_reader.hpp"

namespace limber::app {
namespace {

std::int64_t last_frame_ns(const Recording& recording) {
  return recording.images.empty() ? recording.frames.back().t_ns : recording.images.back().t_ns;
}

std::function<ViewImages(std::size_t, const ViewImageSize&)> images_of(const Recording& recording) {
  if (recording.images.empty()) return {};
  struct Shared {
    explicit Shared(const Recording& of) : reader(of) {}
    std::mutex mutex;
    PairReader reader;
  };
  auto shared = std::make_shared<Shared>(recording);
  return [shared](std::size_t pair, const ViewImageSize& size) {
    const std::lock_guard lock(shared->mutex);
    const auto images = shared->reader.read(pair);
    return ViewImages{encode_jpeg(images[0].view(), size.jpeg_quality, size.most_width),
                      encode_jpeg(images[1].view(), size.jpeg_quality, size.most_width)};
  };
}

std::vector<ViewPoint> points_of(const ObservedFrame& frame) {
  std::unordered_set<std::int64_t> refused;
  for (const Refusal& refusal : frame.report.refused) {
    refused.insert(refusal.track_id);
  }
  const bool updated = frame.report.status == UpdateStatus::kUpdated;
  const Estimate& estimate = frame.navigator->estimate();
  std::vector<ViewPoint> out;
  for (const StereoObservation& seen : frame.frame->observations) {
    ViewPointFate fate = ViewPointFate::kOther;
    if (refused.contains(seen.track_id)) {
      fate = ViewPointFate::kRefused;
    } else if (updated && estimate.find(seen.track_id) != nullptr) {
      fate = ViewPointFate::kUsed;
    }
    out.push_back({seen, fate});
  }
  return out;
}

std::vector<ViewLandmark> map_of(const Estimate& estimate) {
  const std::vector<Eigen::Vector3d> positions = estimate.landmark_positions();
  std::vector<ViewLandmark> out;
  for (std::size_t k = 0; k < positions.size(); ++k) {
    if (positions[k].allFinite()) {  // not the points at infinity
      out.push_back({estimate.landmarks()[k].track_id, positions[k]});
    }
  }
  return out;
}

std::string status_of(const ObservedFrame& frame) {
  if (frame.navigator == nullptr) return "used up by the start";
  std::string text = to_string(frame.report.status);
  if (frame.report.inputs.status != InputStatus::kNotNeeded) {
    text += ", inputs " + to_string(frame.report.inputs.status);
  }
  return frame.report.reset ? text + ", began anew" : text;
}

}  // namespace

ViewRun view_run_of(const Recording& recording, const RunOptions& options) {
  return {recording.name, std::string(to_string(options.method)), frame_count(recording),
          set_up_run(recording, options).calibration, watch_options(options)};
}

ViewFrames::ViewFrames(const Recording& recording, std::shared_ptr<const FrontendRecord> frontend)
    : recording_(recording), frontend_(std::move(frontend)), images_(images_of(recording)) {}

void ViewFrames::take(const ObservedFrame& frame) {
  if (count_++ == 0) {
    begin_ns_ = frame.row.t_ns;
  }
  t_s_ = seconds_between(begin_ns_, frame.row.t_ns);
  is_last_ = frame.row.t_ns == last_frame_ns(recording_);
  keep_health(frame.report);
}

void ViewFrames::keep_health(const FrameReport& report) {
  if (windows_.empty() || (report.calibration && report.calibration != windows_.back().calibration)) {
    FrameReport window;
    window.t_ns = report.t_ns;
    window.calibration = report.calibration;
    windows_.push_back(std::move(window));
  }
}

std::vector<ViewStage> ViewFrames::stages_of(std::int64_t t_ns) const {
  std::vector<ViewStage> out;
  if (frontend_) {
    const auto& times = frontend_->t_ns;
    const auto at = std::lower_bound(times.begin(), times.end(), t_ns);
    if (at != times.end() && *at == t_ns) {
      const auto k = static_cast<std::size_t>(at - times.begin());
      out.push_back({"read images", frontend_->decode_ms[k]});
      out.push_back({"track points", frontend_->track_ms[k]});
    }
  }
  return out;
}

ViewFrame ViewFrames::view_of(const ObservedFrame& frame, const ViewImageSize& size) const {
  const std::int64_t t_ns = frame.row.t_ns;
  ViewFrame out;
  out.number = count_;
  out.t_s = t_s_;
  out.T_world_body = frame.row.T_world_body;
  out.v_world_body = frame.row.v_world_body;
  if (frame.row.covariance) {
    out.sigma = frame.row.covariance->diagonal().cwiseMax(0.0).cwiseSqrt();
  }
  out.status = status_of(frame);
  out.stages = stages_of(t_ns);
  out.stages.push_back({"filter", frame.filter_ms});
  out.health = summarize_health(windows_);
  if (frame.navigator != nullptr) {
    out.points = points_of(frame);
    out.map = map_of(frame.navigator->estimate());
  }
  out.images = images_at(t_ns, size);
  return out;
}

ViewFrame ViewFrames::view_of(const WaitingFrame& frame, const ViewImageSize& size) const {
  ViewFrame out;
  out.number = frame.number;
  out.t_s = frame.report.waited_s;
  out.waiting = true;
  out.status = "start: " + frame.report.missing;
  out.stages = stages_of(frame.frame.t_ns);
  for (const StereoObservation& seen : frame.frame.observations) {
    out.points.push_back({seen, ViewPointFate::kOther});
  }
  out.images = images_at(frame.frame.t_ns, size);
  return out;
}

std::function<ViewImages()> ViewFrames::images_at(std::int64_t t_ns, const ViewImageSize& size) const {
  if (!images_) return {};
  const auto& pairs = recording_.images;
  const auto pair = std::lower_bound(pairs.begin(), pairs.end(), t_ns,
                                     [](const ImagePair& a, std::int64_t t) { return a.t_ns < t; });
  if (pair == pairs.end() || pair->t_ns != t_ns) return {};
  const auto n = static_cast<std::size_t>(pair - pairs.begin());
  return [images = images_, n, size] { return images(n, size); };
}

}  // namespace limber::app
