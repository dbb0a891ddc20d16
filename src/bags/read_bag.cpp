// SPDX-License-Identifier: MIT
#include "limber/bags/read_bag.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <sstream>
#include <utility>

#include "bag_images.hpp"
#include "io/image_size.hpp"
#include "io/numbers.hpp"
#include "limber/core/errors.hpp"
#include "limber/core/nearest_word.hpp"
#include "limber/datasets/replace_calibration.hpp"

namespace limber {
namespace {

namespace fs = std::filesystem;

constexpr double kClockJump = 1.0;        // [s] that no delay of a message explains
constexpr double kRealDifference = 1e-3;  // [s] between left and right: below it, stamps are not that good
constexpr double kSynchronised = 1e-3;    // [s] spread of that difference
constexpr double kLargestBagRate = 1e4;   // [rad/s], as in EuRoC files
constexpr double kLargestBagForce = 1e5;  // [m/s^2]
constexpr double kLargestBagSpeed = 1e5;  // [m/s]
constexpr std::int64_t kLatestStamp = 4'000'000'000'000'000'000;  // [ns]

bool is_image(MessageKind kind) {
  return kind == MessageKind::kImage || kind == MessageKind::kCompressedImage;
}

/// Builds a Recording from what a scan found.
class BagReader {
 public:
  BagReader(const fs::path& path, Recording& recording) : path_(path), recording_(recording) {}

  void read(const BagTopics& asked, const std::function<void(std::size_t)>& progress);

 private:
  [[noreturn]] void fail(const std::string& expected, const std::string& found) const {
    throw DataError(path_.string(), 0, expected, found);
  }
  void choose(const BagTopics& asked);
  [[nodiscard]] const BagStream* stream(const std::string& role, const std::string& topic,
                                        const std::string& types, bool (*fits)(MessageKind)) const;
  [[nodiscard]] std::vector<std::size_t> in_order(const BagStream& stream);
  [[nodiscard]] std::string why_no_pair() const;
  void read_images();
  [[nodiscard]] std::optional<detail::ImageSize> usual_size(const BagStream& stream) const;
  void check_image(const BagStream& stream, Camera& camera);
  void judge_differences(const PairedTimes& paired, std::size_t left, std::size_t right);
  void read_imu(const BagStream& stream);
  void read_odometry(const BagStream& stream);
  void read_truth(const BagStream& stream);
  void note(std::string text) { recording_.notes.push_back(std::move(text)); }

  fs::path path_;
  Recording& recording_;
  std::unique_ptr<BagFile> bag_;
  BagContents contents_;
  BagTopics topics_;
};

const BagStream* BagReader::stream(const std::string& role, const std::string& topic,
                                   const std::string& types, bool (*fits)(MessageKind)) const {
  if (topic.empty()) {
    return nullptr;
  }
  std::vector<std::string> names;
  for (const BagStream& candidate : contents_.streams) {
    names.push_back(candidate.topic.name);
    if (candidate.topic.name != topic) {
      continue;
    }
    if (!fits(candidate.kind)) {
      fail(fmt::format("{} for {}", types, role),
           fmt::format("{} of type {}, serialised as {}", topic, candidate.topic.type,
                       candidate.topic.serialization_name));
    }
    if (candidate.stamps_ns.empty()) {
      fail(fmt::format("messages of {}", topic),
           fmt::format("{}, none of them readable", candidate.messages));
    }
    return &candidate;
  }
  const auto meant = nearest_word(topic, names);
  fail(fmt::format("the topic {} ({})", topic, role),
       fmt::format("no such topic{}; limber info {} lists them",
                   meant ? ", did you mean " + *meant + "?" : "", path_.string()));
}

/// detail::order_by_stamp, and notes.
std::vector<std::size_t> BagReader::in_order(const BagStream& stream) {
  const std::string& name = stream.topic.name;
  if (!stream.stamped) {
    note(name + ": the headers have no stamps, the times of recording stand in for them");
  }
  const Timing timing = timing_of(stream.stamps_ns);
  if (timing.largest_step_back_s > kClockJump) {
    fail(name + " with a clock that does not jump back",
         fmt::format("a jump back by {:.3f} s behind {} ns; cut the bag there and run the parts",
                     timing.largest_step_back_s, timing.stepped_back_at_ns));
  }
  if (timing.first_ns < -kLatestStamp || timing.last_ns > kLatestStamp) {
    fail(name + " with stamps before the year 2096", fmt::format("{} ns", timing.last_ns));
  }
  std::vector<std::size_t> order = detail::order_by_stamp(stream);
  if (timing.backward > 0) {
    note(fmt::format("{}: {} messages are older than one before them; they are put in order", name,
                     timing.backward));
  }
  if (const std::size_t repeated = stream.stamps_ns.size() - order.size(); repeated > 0) {
    note(fmt::format("{}: {} messages have the stamp of another one and are left out", name, repeated));
  }
  if (stream.unstamped > 0) {
    note(fmt::format("{}: {} of {} messages have no stamp and are left out", name, stream.unstamped,
                     stream.messages));
  }
  if (stream.unreadable > 0) {
    note(fmt::format(
        "{}: {} of {} messages are damaged or hold numbers that are not finite; they are left out", name,
        stream.unreadable, stream.messages));
  }
  return order;
}

/// That of most of nine compressed images, evenly over the bag; some may be damaged.
std::optional<detail::ImageSize> BagReader::usual_size(const BagStream& stream) const {
  constexpr std::size_t kLooked = 9;
  const std::size_t all = stream.places.size(), looked = std::min(kLooked, all);
  std::map<std::pair<int, int>, std::size_t> counts;
  for (std::size_t k = 0; k < looked; ++k) {
    try {
      const auto image =
          decode_image(bag_->read(stream.places[k * all / looked]), stream.topic.serialization, stream.kind);
      std::istringstream content(image ? std::string(image->data.begin(), image->data.end()) : "");
      if (const auto size = detail::image_size_of(content)) {
        ++counts[{size->width, size->height}];
      }
    } catch (const DataError&) {
      continue;
    }
  }
  const auto most = std::max_element(counts.begin(), counts.end(),
                                     [](const auto& a, const auto& b) { return a.second < b.second; });
  if (most == counts.end()) {
    return std::nullopt;
  }
  return detail::ImageSize{most->first.first, most->first.second};
}

void BagReader::check_image(const BagStream& stream, Camera& camera) {
  int width = stream.first_image->image.width, height = stream.first_image->image.height;
  if (stream.other_images > 0) {
    const std::string differ =
        fmt::format("{} of {} that differ from the ", stream.other_images, stream.places.size());
    if (2 * stream.other_images > stream.places.size()) {
      fail(stream.topic.name + " with images of one size and encoding", differ + "first");
    }
    note(stream.topic.name + ": images of more than one size or encoding: " + differ + "others");
  }
  recording_.partial |= stream.unreadable > 0;
  if (stream.kind == MessageKind::kCompressedImage) {
    const auto size = usual_size(stream);
    if (!size) {
      fail(stream.topic.name + " with PNG or JPEG images",
           "the format " + detail::excerpt(stream.first_image->format));
    }
    width = size->width;
    height = size->height;
  }
  if (camera.width == 0 && camera.height == 0) {
    camera.width = width;
    camera.height = height;
  }
  if (camera.width != width || camera.height != height) {
    fail(fmt::format("{} with images of {} x {} pixels, as the calibration says", stream.topic.name,
                     camera.width, camera.height),
         fmt::format("{} x {}", width, height));
  }
}

void BagReader::judge_differences(const PairedTimes& paired, std::size_t left, std::size_t right) {
  const std::size_t pairs = paired.pairs.size();
  if (pairs < left || pairs < right) {
    note(fmt::format("{} images of {} and {} of {} have no partner and are left out", left - pairs,
                     topics_.left, right - pairs, topics_.right));
  }
  const double median = paired.median_difference_s;
  if (std::abs(median) >= kRealDifference) {
    recording_.calibration.time_offset_s[1] += median;
    note(fmt::format("right images are stamped {:.2f} ms {} than left ones: taken as their time offset",
                     1e3 * std::abs(median), median > 0.0 ? "later" : "earlier"));
  }
  if (paired.spread_s > kSynchronised) {
    note(fmt::format(
        "left and right images are not synchronised: their stamps differ by up to {:.2f} ms more or "
        "less than usual",
        1e3 * paired.spread_s));
  }
}

/// Why there are not two topics of images.
std::string BagReader::why_no_pair() const {
  if (const std::string& named = topics_.left.empty() ? topics_.right : topics_.left; !named.empty()) {
    return topics_.left == topics_.right ? named + " for both" : named + " alone";
  }
  std::vector<std::string> topics;
  for (const BagStream& stream : contents_.streams) {
    if (!is_image(stream.kind)) {
      continue;
    }
    const std::string encoding = stream.first_image ? stream.first_image->image.encoding : "unreadable";
    topics.push_back(stream.topic.name + (encoding.empty() ? "" : " (" + encoding + ")"));
  }
  return topics.empty() ? "no topic of images"
         : topics.size() == 1
             ? topics.front() + " alone"
             : fmt::format("none of pictures whose names tell left from right: {}", fmt::join(topics, ", "));
}

void BagReader::read_images() {
  constexpr const char* kTypes = "sensor_msgs/Image or sensor_msgs/CompressedImage";
  const BagStream* const streams[] = {stream("left images", topics_.left, kTypes, is_image),
                                      stream("right images", topics_.right, kTypes, is_image)};
  if (streams[0] == nullptr || streams[1] == nullptr || streams[0] == streams[1]) {
    fail("two topics of images, left and right",
         fmt::format("{}; limber info {} lists what there is, --topics left=...,right=... names them",
                     why_no_pair(), path_.string()));
  }
  const bool named_rectified = in_lower_case(topics_.left).find("rect") != std::string::npos;
  if (named_rectified && image_kind(recording_.calibration) == ImageKind::kRaw) {
    note(topics_.left + " is rectified by its name, the calibration is of raw images (with distortion)");
  }
  check_image(*streams[0], recording_.calibration.cam0);
  check_image(*streams[1], recording_.calibration.cam1);
  (void)in_order(*streams[0]);
  (void)in_order(*streams[1]);
  const detail::StereoStreams stereo = detail::pair_streams(*streams[0], *streams[1]);
  if (stereo.paired.pairs.empty()) {
    fail(fmt::format("images of {} and {} at the same times", topics_.left, topics_.right), "none");
  }
  judge_differences(stereo.paired, stereo.stamps_ns[0].size(), stereo.stamps_ns[1].size());
  for (const auto& pair : stereo.paired.pairs) {
    recording_.images.push_back({stereo.stamps_ns[0][pair.first], path_, path_});
  }
  auto images = detail::bag_images(path_, std::move(bag_), *streams[0], *streams[1], stereo);
  if (const int bits = images->find_bits(); bits != 0) {
    note(fmt::format("images of 16 bits, of which {} are used: the highest eight of these are kept", bits));
  }
  recording_.image_store = std::move(images);
}

void BagReader::read_imu(const BagStream& stream) {
  const std::string& name = stream.topic.name;
  for (const std::size_t k : in_order(stream)) {
    const ImuMessage& message = stream.imu[k];
    if (!message.has_rates || !message.has_accelerations) {
      fail(name + " with rates and accelerations in every message",
           std::string("messages without ") + (message.has_rates ? "accelerations" : "rates") +
               ": a driver that sends them on two topics must be told to unite them (RealSense: "
               "unite_imu_method)");
    }
    const ImuSample& sample = message.sample;
    if (!(sample.omega_imu.cwiseAbs().maxCoeff() <= kLargestBagRate) ||
        !(sample.accel_imu.cwiseAbs().maxCoeff() <= kLargestBagForce)) {
      fail(fmt::format("{} within {} rad/s and {} m/s^2", name, kLargestBagRate, kLargestBagForce),
           fmt::format("more, at {} ns", sample.t_ns));
    }
    recording_.imu.push_back(sample);
  }
}

void BagReader::read_odometry(const BagStream& stream) {
  for (const std::size_t k : in_order(stream)) {
    const OdometrySample& sample = stream.twists[k];
    if (!(sample.v_body.cwiseAbs().maxCoeff() <= kLargestBagSpeed) ||
        !(sample.omega_body.cwiseAbs().maxCoeff() <= kLargestBagRate)) {
      fail(fmt::format("{} within {} m/s and {} rad/s", stream.topic.name, kLargestBagSpeed, kLargestBagRate),
           fmt::format("more, at {} ns", sample.t_ns));
    }
    recording_.odometry.push_back(sample);
  }
  note(stream.topic.name + ": taken for velocities of the body that the calibration speaks of");
}

void BagReader::read_truth(const BagStream& stream) {
  for (const std::size_t k : in_order(stream)) {
    GroundTruthState state;
    state.t_ns = stream.poses[k].t_ns;
    state.R_world_body = stream.poses[k].T_world_body.R;
    state.p_world_body = stream.poses[k].T_world_body.p;
    recording_.truth.motion.states.push_back(state);
  }
  note(stream.topic.name +
       ": taken for the true poses of the body; if they are those of markers beside it, errors contain the "
       "distance");
}

void BagReader::choose(const BagTopics& asked) {
  const TopicProposal proposal = propose_topics(contents_);
  topics_ = asked;
  const bool images_asked = !asked.left.empty() || !asked.right.empty();
  const bool motion_asked = !asked.imu.empty() || !asked.odometry.empty();
  if (!images_asked) {
    topics_.left = proposal.topics.left;
    topics_.right = proposal.topics.right;
  }
  if (!motion_asked) {
    topics_.imu = proposal.topics.imu;
    topics_.odometry = proposal.topics.odometry;
  }
  if (asked.truth.empty()) {
    topics_.truth = proposal.topics.truth;
  }
  if (topics_ != asked) {
    note("topics: " + format_bag_topics(topics_));
    recording_.notes.insert(recording_.notes.end(), proposal.notes.begin(), proposal.notes.end());
  }
}

void BagReader::read(const BagTopics& asked, const std::function<void(std::size_t)>& progress) {
  bag_ = open_bag(path_);
  contents_ = scan_bag(*bag_, {}, progress);
  for (const std::string& damage : contents_.damages) {
    note(damage);
  }
  recording_.partial = !contents_.whole;
  choose(asked);
  read_images();
  const auto* imu = stream("the IMU", topics_.imu, "sensor_msgs/Imu",
                           [](MessageKind kind) { return kind == MessageKind::kImu; });
  if (imu != nullptr && recording_.calibration.body == BodyFrame::kImu) {
    read_imu(*imu);
  } else if (imu != nullptr) {
    note(topics_.imu + " is not used: the calibration does not say where the IMU sits (T_cam_imu)");
  }
  if (const auto* odometry = stream(
          "odometry", topics_.odometry, "nav_msgs/Odometry or geometry_msgs/TwistStamped",
          [](MessageKind kind) { return kind == MessageKind::kOdometry || kind == MessageKind::kTwist; })) {
    read_odometry(*odometry);
  }
  if (const auto* truth = stream(
          "the truth", topics_.truth, "geometry_msgs/PoseStamped, TransformStamped or nav_msgs/Odometry",
          [](MessageKind kind) { return kind == MessageKind::kOdometry || kind == MessageKind::kPose; })) {
    read_truth(*truth);
  }
}

}  // namespace

Recording read_bag(const fs::path& path, const StereoCalibration& calibration,
                   const std::optional<ImuNoise>& imu_noise, const BagTopics& asked,
                   const std::function<void(std::size_t)>& progress) {
  Recording recording;
  recording.path = path;
  recording.name = fs::weakly_canonical(path).stem().string();
  recording.calibration = calibration;
  recording.imu_noise = imu_noise;
  BagReader(path, recording).read(asked, progress);
  return recording;
}

}  // namespace limber
