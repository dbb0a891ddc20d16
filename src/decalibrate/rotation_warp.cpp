// SPDX-License-Identifier: MIT
#include "decalibrate/rotation_warp.hpp"

#include <atomic>
#include <opencv2/core/utility.hpp>
#include <opencv2/imgproc.hpp>

namespace limber::decalibrate {

RotationWarp::RotationWarp(const Camera& camera)
    : camera_(camera),
      map_(camera.height, camera.width, CV_32FC2),
      black_(camera.height, camera.width, CV_8U) {
  bearings_.resize(static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height));
  cv::parallel_for_({0, camera.height}, [&](const cv::Range& rows) {
    for (int v = rows.start; v < rows.end; ++v) {
      for (int u = 0; u < camera.width; ++u) {
        bearings_[static_cast<std::size_t>(v * camera.width + u)] = unproject(camera, Eigen::Vector2d(u, v));
      }
    }
  });
}

void RotationWarp::make_map(const Eigen::Matrix3d& turn) {
  const Eigen::Matrix3d back = turn.transpose();
  std::atomic<int> black_pixels = 0;
  cv::parallel_for_({0, camera_.height}, [&](const cv::Range& rows) {
    int missing = 0;
    for (int v = rows.start; v < rows.end; ++v) {
      auto* row = map_.ptr<cv::Vec2f>(v);
      for (int u = 0; u < camera_.width; ++u) {
        const auto& bearing = bearings_[static_cast<std::size_t>(v * camera_.width + u)];
        const auto seen = bearing ? project(camera_, back * *bearing) : std::nullopt;
        const bool inside = seen && seen->uv.x() > -0.5 && seen->uv.y() > -0.5 &&
                            seen->uv.x() < camera_.width - 0.5 && seen->uv.y() < camera_.height - 0.5;
        row[u] = inside ? cv::Vec2f(static_cast<float>(seen->uv.x()), static_cast<float>(seen->uv.y()))
                        : cv::Vec2f();
        black_.at<std::uint8_t>(v, u) = inside ? 0 : 255;
        missing += !inside;
      }
    }
    black_pixels += missing;
  });
  turn_ = turn;
  black_share_ = static_cast<double>(black_pixels) / static_cast<double>(bearings_.size());
}

cv::Mat RotationWarp::operator()(const cv::Mat& image, const Eigen::Matrix3d& turn) {
  if (turn != turn_) make_map(turn);
  cv::Mat warped;
  cv::remap(image, warped, map_, {}, cv::INTER_LANCZOS4, cv::BORDER_REPLICATE);
  warped.setTo(cv::Scalar::all(0.0), black_);
  return warped;
}

}  // namespace limber::decalibrate
