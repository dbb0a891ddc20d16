// SPDX-License-Identifier: MIT
#include "render/truth_files.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>

#include "limber/core/time.hpp"
#include "limber/io/atomic_file.hpp"

namespace limber::detail {
namespace {

namespace fs = std::filesystem;

std::string row_of(const Eigen::Vector3d& v) { return fmt::format("{},{},{}", v.x(), v.y(), v.z()); }

std::string walls_text(const Scene& scene) {
  std::string text =
      "#corner x,y,z [m],u x,y,z,v x,y,z,width [m],height [m],plain; seen from the side of u x v\n";
  for (const Wall& w : scene.walls()) {
    text += fmt::format("{},{},{},{},{},{}\n", row_of(w.corner), row_of(w.u), row_of(w.v), w.width, w.height,
                        scene.is_plain(w) ? 1 : 0);
  }
  return text;
}

std::string boxes_text(const Scene& scene) {
  std::string text =
      "#box,half size x,y,z [m],middle x,y,z [m],swing x,y,z [m],frequency [rad/s],at [s],yaw [rad],"
      "yaw rate [rad/s]; centre = middle + swing sin(frequency (t - at)); turned about z by yaw + yaw rate "
      "(t - at)\n";
  for (std::size_t k = 0; k < scene.boxes().size(); ++k) {
    const MovingBox& b = scene.boxes()[k];
    text += fmt::format("{},{},{},{},{},{},{},{}\n", k, row_of(b.half_size), row_of(b.middle),
                        row_of(b.swing), b.angular_frequency, b.at, b.yaw, b.yaw_rate);
  }
  return text;
}

std::string box_poses_text(const Scene& scene, const std::vector<std::int64_t>& times_ns) {
  std::string text = "#timestamp [ns],box,p_world_box x,y,z [m],q_world_box w,x,y,z\n";
  for (const std::int64_t t_ns : times_ns) {
    for (std::size_t k = 0; k < scene.boxes().size(); ++k) {
      const Pose pose = scene.boxes()[k].pose(to_seconds(t_ns));
      const Eigen::Quaterniond q(pose.R);
      text += fmt::format("{},{},{},{},{}\n", t_ns, k, row_of(pose.p), q.w(), row_of(q.vec()));
    }
  }
  return text;
}

}  // namespace

void write_scene(const Scene& scene, const std::vector<std::int64_t>& times_ns, const fs::path& folder) {
  write_staged_file(folder / "data.csv", walls_text(scene));
  if (scene.boxes().empty()) return;
  write_staged_file(folder / "moving_boxes.csv", boxes_text(scene));
  write_staged_file(folder / "moving_box_poses.csv", box_poses_text(scene, times_ns));
}

void write_faulty_frames(const std::vector<std::int64_t>& times_ns, const std::vector<FramePictures>& frames,
                         const fs::path& file) {
  std::string text = "#timestamp [ns],cam0 shows,cam1 shows\n";
  for (std::size_t n = 0; n < frames.size(); ++n) {
    if (frames[n].sound()) continue;
    const auto shows = [&](std::size_t camera) {
      const bool left = (camera == 0) != frames[n].swapped;
      return !frames[n].has[camera] ? "nothing" : left ? "left" : "right";
    };
    text += fmt::format("{},{},{}\n", times_ns[n], shows(0), shows(1));
  }
  write_staged_file(file, text);
}

}  // namespace limber::detail
