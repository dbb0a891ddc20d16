// SPDX-License-Identifier: MIT
#include "limber/view/view_recorder.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string_view>

#include "encode.hpp"
#include "io/base64.hpp"
#include "limber/io/atomic_file.hpp"
#include "page_template.hpp"
#include "thinned_path.hpp"

namespace limber {
namespace {

/// JSON that cannot end the HTML element that holds it.
std::string as_script_data(std::string_view json) {
  std::string out;
  for (const char c : json) {
    out += c == '<' ? std::string("\\u003c") : std::string(1, c);
  }
  return out;
}

}  // namespace

ViewRecorder::ViewRecorder(ViewRun run)
    : run_(std::move(run)),
      stride_(std::max<std::size_t>(1, (run_.frames + kMostFrames - 1) / kMostFrames)),
      path_(std::make_unique<detail::ThinnedPath>()) {}

ViewRecorder::~ViewRecorder() = default;

void ViewRecorder::note(double t_s, const Eigen::Vector3d& p_world_body) { path_->add(t_s, p_world_body); }

bool ViewRecorder::wants(std::size_t number) const {
  return number % stride_ == 0 && frames_.size() < kMostFrames;
}

void ViewRecorder::add(const ViewFrame& frame) {
  frames_.push_back(as_script_data(detail::to_json(frame, run_.watch)));
}

void ViewRecorder::write(const std::filesystem::path& file, const std::string& message) const {
  const std::string_view page = detail::view_page();
  const std::size_t data = page.find(detail::kViewDataPlace);
  const std::string path = detail::to_base64(std::span<const float>(path_->values()));
  AtomicFile out(file);
  out.write(page.substr(0, data));
  out.write(R"({"run":)" + as_script_data(detail::to_json(run_)) + R"(,"path":")" + path + R"(","message":)" +
            as_script_data(detail::json_string(message)) + R"(,"frames":[)");
  for (std::size_t k = 0; k < frames_.size(); ++k) {
    out.write(k == 0 ? "" : ",");
    out.write(frames_[k]);
  }
  out.write("]}");
  out.write(page.substr(data + detail::kViewDataPlace.size()));
  out.commit();
}

}  // namespace limber
