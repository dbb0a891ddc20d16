// SPDX-License-Identifier: MIT
// Feeds image pairs to libviso2 by its public API: every pair, in the order of time, rectified with the given
// calibration. Writes the pose of the body after each pair, before the next is read (causal), and what that
// took. benchmarks/peers/README.md says more.
#include <array>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <iostream>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <opencv2/core/quaternion.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "read_recording.hpp"
#include "viso_stereo.h"

namespace {

struct Rig {
  bool rectified = false;
  std::array<cv::Mat, 2> K, distortion;
  cv::Matx44d T_cam1_cam0, T_body_cam0;
};

/// A key of a file of OpenCV.
template <typename T>
T value(const cv::FileStorage& file, const std::string& key, const std::string& path) {
  if (file[key].empty()) throw std::runtime_error(path + ": expected " + key);
  T found;
  file[key] >> found;
  return found;
}

Rig read_rig(const std::string& path) {
  const cv::FileStorage file(path, cv::FileStorage::READ);
  if (!file.isOpened()) throw std::runtime_error(path + ": cannot be read");
  Rig rig;
  rig.rectified = value<int>(file, "rectified", path) != 0;
  for (std::size_t i = 0; i < 2; ++i) {
    rig.K[i] = value<cv::Mat>(file, "K" + std::to_string(i), path);
    rig.distortion[i] = value<cv::Mat>(file, "distortion" + std::to_string(i), path);
  }
  rig.T_cam1_cam0 = value<cv::Mat>(file, "T_cam1_cam0", path);
  rig.T_body_cam0 = value<cv::Mat>(file, "T_body_cam0", path);
  return rig;
}

/// Turns image pairs so that rows correspond, as libviso2 expects them. Pairs of a rectified rig stay as they
/// are.
class Rectifier {
 public:
  Rectifier(const Rig& rig, cv::Size size) : rectified_(rig.rectified), size_(size) {
    cv::Matx33d R_rect_cam0 = cv::Matx33d::eye();
    if (rectified_) {
      rig.K[0].copyTo(K_);
      baseline_ = -rig.T_cam1_cam0(0, 3);
    } else {
      const cv::Mat T(rig.T_cam1_cam0), R = T(cv::Rect(0, 0, 3, 3)), t = T(cv::Rect(3, 0, 1, 3));
      std::array<cv::Mat, 2> turn, P;
      cv::Mat Q;
      cv::stereoRectify(rig.K[0], rig.distortion[0], rig.K[1], rig.distortion[1], size_, R, t, turn[0],
                        turn[1], P[0], P[1], Q, cv::CALIB_ZERO_DISPARITY,
                        0);  // 0: no pixel that a camera did not see
      for (std::size_t i = 0; i < 2; ++i)
        cv::initUndistortRectifyMap(rig.K[i], rig.distortion[i], turn[i], P[i], size_, CV_16SC2, maps_[i][0],
                                    maps_[i][1]);
      P[0](cv::Rect(0, 0, 3, 3)).copyTo(K_);
      baseline_ = -P[1].at<double>(0, 3) / P[1].at<double>(0, 0);
      R_rect_cam0 = turn[0];
    }
    cv::Matx44d T_rect_cam0 = cv::Matx44d::eye();
    for (int i = 0; i < 9; ++i) T_rect_cam0(i / 3, i % 3) = R_rect_cam0.val[i];
    T_body_rect_ = rig.T_body_cam0 * T_rect_cam0.inv();
  }

  cv::Mat operator()(const cv::Mat& image, std::size_t camera) const {
    if (image.size() != size_) throw std::runtime_error("expected images of one size");
    if (rectified_) return image;
    cv::Mat turned;
    cv::remap(image, turned, maps_[camera][0], maps_[camera][1], cv::INTER_LINEAR);
    return turned;
  }

  const cv::Mat& K() const { return K_; }                          ///< 3 x 3 [px], of both
  double baseline() const { return baseline_; }                    ///< [m]
  const cv::Matx44d& T_body_rect() const { return T_body_rect_; }  ///< of the rectified left camera

 private:
  bool rectified_;
  cv::Size size_;
  std::array<std::array<cv::Mat, 2>, 2> maps_;
  cv::Mat K_;
  double baseline_ = 0;
  cv::Matx44d T_body_rect_;
};

/// The library's own settings, and the calibration.
VisualOdometryStereo::parameters settings(const Rectifier& rectifier) {
  VisualOdometryStereo::parameters parameters;
  parameters.calib.f = rectifier.K().at<double>(0, 0);
  parameters.calib.cu = rectifier.K().at<double>(0, 2);
  parameters.calib.cv = rectifier.K().at<double>(1, 2);
  parameters.base = rectifier.baseline();
  return parameters;
}

/// The motion of the last step: p_now = T p_before, in the rectified left camera.
cv::Matx44d last_motion(VisualOdometryStereo& odometry) {
  const Matrix motion = odometry.getMotion();
  cv::Matx44d T;
  for (int i = 0; i < 16; ++i) T(i / 4, i % 4) = motion.val[i / 4][i % 4];
  return T;
}

/// Poses in the columns of EuRoC's ground truth.
class Trajectory {
 public:
  explicit Trajectory(const std::string& path) : out_(path) {
    if (!out_) throw std::runtime_error(path + ": cannot be written");
    out_.precision(12);
    out_ << "#timestamp [ns],p_x [m],p_y [m],p_z [m],q_w [],q_x [],q_y [],q_z []\n";
  }

  void add(const std::string& t_ns, const cv::Matx44d& T) {
    const cv::Quatd q = cv::Quatd::createFromRotMat(T.get_minor<3, 3>(0, 0));
    out_ << t_ns << ',' << T(0, 3) << ',' << T(1, 3) << ',' << T(2, 3) << ',' << q.w << ',' << q.x << ','
         << q.y << ',' << q.z << '\n';
    ++poses_;
  }

  std::size_t poses() const { return poses_; }

 private:
  std::ofstream out_;
  std::size_t poses_ = 0;
};

struct Totals {
  std::size_t frames = 0, poses = 0;
  double decode_s = 0, rectify_s = 0, estimate_s = 0, matches = 0, inliers = 0;
};

/// Every pair. A step that libviso2 gives up has no pose, and its motion is missing from then on, as in
/// libviso2's own demo.
Totals navigate(const std::string& rig_path, const std::string& pairs_path, const std::string& out_path,
                unsigned seed) {
  cv::setNumThreads(0);
  const auto pairs = read_csv(pairs_path, '\t');  // names of recordings hold commas
  for (const auto& row : pairs)
    if (row.size() != 3)
      throw std::runtime_error(pairs_path + ": expected t_ns, left image, right image, tabs between them");
  if (pairs.empty()) throw std::runtime_error(pairs_path + ": no pairs");
  const Rectifier rectifier(read_rig(rig_path), read_image(pairs.front()[1]).size());
  VisualOdometryStereo odometry(settings(rectifier));
  std::srand(seed);  // of its RANSAC; its constructor takes 0
  Trajectory trajectory(out_path);
  Totals totals;
  cv::Matx44d T_first_rect = cv::Matx44d::eye();
  for (const auto& row : pairs) {
    const double begin = cpu_seconds();
    std::array<cv::Mat, 2> images{read_image(row[1]), read_image(row[2])};
    const double decoded = cpu_seconds();
    for (std::size_t i = 0; i < 2; ++i) images[i] = rectifier(images[i], i);
    const double turned = cpu_seconds();
    std::array<std::int32_t, 3> size{images[0].cols, images[0].rows,
                                     static_cast<std::int32_t>(images[0].step)};
    const bool moved = odometry.process(images[0].data, images[1].data, size.data());
    const double done = cpu_seconds();
    if (moved) {
      T_first_rect = T_first_rect * last_motion(odometry).inv();
      totals.matches += odometry.getNumberOfMatches();
      totals.inliers += odometry.getNumberOfInliers();
    }
    if (moved || totals.frames == 0)
      trajectory.add(row[0], rectifier.T_body_rect() * T_first_rect * rectifier.T_body_rect().inv());
    ++totals.frames;
    totals.decode_s += decoded - begin;
    totals.rectify_s += turned - decoded;
    totals.estimate_s += done - decoded;
  }
  totals.poses = trajectory.poses();
  return totals;
}

/// Times are means of a frame; `estimate_ms` holds `rectify_ms`.
void print(const Totals& totals) {
  const double frames = static_cast<double>(totals.frames),
               steps = totals.poses > 1 ? static_cast<double>(totals.poses - 1) : 1.0;
  std::printf(
      "{\"frames\": %zu, \"poses\": %zu, \"decode_ms\": %.4f, \"rectify_ms\": %.4f, \"estimate_ms\": %.4f, "
      "\"matches\": %.2f, "
      "\"inliers\": %.2f}\n",
      totals.frames, totals.poses, 1e3 * totals.decode_s / frames, 1e3 * totals.rectify_s / frames,
      1e3 * totals.estimate_s / frames, totals.matches / steps, totals.inliers / steps);
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::string> words(argv + 1, argv + argc);
  try {
    if (words.size() != 4) {
      std::cerr << "libviso2_runner RIG PAIRS TRAJECTORY SEED\n";
      return 2;
    }
    print(navigate(words[0], words[1], words[2], static_cast<unsigned>(std::stoul(words[3]))));
  } catch (const std::exception& error) {
    std::cerr << "libviso2_runner: " << error.what() << '\n';
    return 1;
  }
  return 0;
}
