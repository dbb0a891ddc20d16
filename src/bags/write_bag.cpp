// SPDX-License-Identifier: MIT
#include "limber/bags/write_bag.hpp"

#include <limits>
#include <stdexcept>

#include "datasets/copied_images.hpp"
#include "message_sink.hpp"
#include "message_writer.hpp"

namespace limber {
namespace {

using detail::MessageSink;
using detail::MessageType;
using detail::MessageWriter;
namespace types = detail::types;

std::vector<std::uint8_t> imu_message(const ImuSample& sample, Serialization serialization) {
  MessageWriter out(serialization);
  out.header(sample.t_ns, "imu0");
  out.vector3(Eigen::Vector3d::Zero());
  out.number(1.0);
  out.unknown_covariance(9, -1.0);  // no orientation
  out.vector3(sample.omega_imu);
  out.unknown_covariance(9);
  out.vector3(sample.accel_imu);
  out.unknown_covariance(9);
  return out.take();
}

std::vector<std::uint8_t> twist_message(const OdometrySample& sample, Serialization serialization) {
  MessageWriter out(serialization);
  out.header(sample.t_ns, "body");
  out.vector3(sample.v_body);
  out.vector3(sample.omega_body);
  return out.take();
}

std::vector<std::uint8_t> truth_message(const GroundTruthState& state, Serialization serialization) {
  MessageWriter out(serialization);
  out.header(state.t_ns, "world");
  out.text("body");
  out.pose({state.R_world_body, state.p_world_body});
  out.unknown_covariance(36);
  out.vector3(state.R_world_body.transpose() * state.v_world_body);
  out.vector3(Eigen::Vector3d::Zero());
  out.unknown_covariance(36);
  return out.take();
}

std::vector<std::uint8_t> image_message(const EncodedImage& image, std::int64_t t_ns, std::string_view frame,
                                        Serialization serialization) {
  MessageWriter out(serialization);
  out.header(t_ns, frame);
  if (image.encoding.empty()) {
    const bool jpeg = image.data.size() > 2 && image.data[0] == 0xff && image.data[1] == 0xd8;
    out.text(jpeg ? "jpeg" : "png");
  } else {
    out.number(static_cast<std::uint32_t>(image.height));
    out.number(static_cast<std::uint32_t>(image.width));
    out.text(image.encoding);
    out.flag(image.big_endian);
    out.number(static_cast<std::uint32_t>(image.step));
  }
  out.data(image.data);
  return out.take();
}

/// Writes a recording's streams side by side in the order of time.
class RecordingWriter {
 public:
  RecordingWriter(const Recording& recording, MessageSink& sink) : recording_(recording), sink_(sink) {}

  /// Everything but images up to a time.
  void up_to(std::int64_t t_ns) {
    put(recording_.imu, imu_, t_ns, "/imu0", types::kImu, imu_message);
    put(recording_.odometry, odometry_, t_ns, "/odometry", types::kTwistStamped, twist_message);
    put(recording_.truth.motion.states, truth_, t_ns, "/groundtruth", types::kOdometry, truth_message);
  }
  void image(std::size_t camera, std::int64_t t_ns, const EncodedImage& image) {
    const std::string frame = camera == 0 ? "cam0" : "cam1", topic = "/" + frame + "/image_raw";
    const std::uint16_t channel = image.encoding.empty()
                                      ? sink_.channel(topic + "/compressed", types::kCompressedImage)
                                      : sink_.channel(topic, types::kImage);
    sink_.message(channel, t_ns, image_message(image, t_ns, frame, sink_.serialization()));
  }

 private:
  template <typename Sample>
  void put(const std::vector<Sample>& samples, std::size_t& next, std::int64_t t_ns, const char* topic,
           const MessageType& type, std::vector<std::uint8_t> (*message)(const Sample&, Serialization)) {
    for (; next < samples.size() && samples[next].t_ns <= t_ns; ++next) {
      const auto bytes = message(samples[next], sink_.serialization());
      sink_.message(sink_.channel(topic, type), samples[next].t_ns, bytes);
    }
  }

  const Recording& recording_;
  MessageSink& sink_;
  std::size_t imu_ = 0, odometry_ = 0, truth_ = 0;
};

}  // namespace

std::vector<LostImage> write_bag(const Recording& recording, const BagOutput& output,
                                 const ImageChange& change, const std::function<void(std::size_t)>& progress,
                                 const std::function<bool()>& stop) {
  if (recording.images.empty()) {
    throw std::invalid_argument("write_bag: the recording has no images");
  }
  const auto sink = detail::open_sink(output);
  RecordingWriter writer(recording, *sink);
  detail::CopiedImages images(recording, change);
  for (std::size_t n = 0; n < recording.images.size(); ++n) {
    if (stop && stop()) {
      throw std::runtime_error("stopped: nothing is written");
    }
    const std::int64_t t_ns = recording.images[n].t_ns;
    writer.up_to(t_ns);
    for (std::size_t c = 0; c < 2; ++c) {
      if (const auto image = images.take(c, n)) {
        writer.image(c, t_ns, *image);
      }
    }
    if (progress) {
      progress(n + 1);
    }
  }
  writer.up_to(std::numeric_limits<std::int64_t>::max());
  sink->close();
  return images.lost();
}

}  // namespace limber
