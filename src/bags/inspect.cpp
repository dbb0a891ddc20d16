// SPDX-License-Identifier: MIT
#include "limber/bags/inspect.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "bag_images.hpp"
#include "io/image_size.hpp"
#include "io/times_of.hpp"
#include "limber/core/errors.hpp"
#include "limber/core/median.hpp"
#include "limber/core/time.hpp"
#include "limber/datasets/image_files.hpp"
#include "limber/datasets/read_recording.hpp"

namespace limber {
namespace {

namespace fs = std::filesystem;

std::string role_of(const std::string& topic, const BagTopics& topics) {
  return topic == topics.left       ? "left"
         : topic == topics.right    ? "right"
         : topic == topics.imu      ? "imu"
         : topic == topics.odometry ? "odometry"
         : topic == topics.truth    ? "truth"
                                    : "";
}

StreamInfo info_of(const BagStream& stream, const BagTopics& topics) {
  StreamInfo out;
  out.name = stream.topic.name;
  out.type = stream.topic.type.empty() ? stream.topic.serialization_name : stream.topic.type;
  out.role = role_of(out.name, topics);
  out.timing = timing_of(stream.stamps_ns);
  out.stamped = stream.stamped;
  out.messages = stream.messages;
  out.unreadable = stream.unreadable;
  out.unstamped = stream.unstamped;
  out.other_images = stream.other_images;
  if (stream.stamped && !stream.stamps_ns.empty()) {
    std::vector<double> delays;
    for (std::size_t k = 0; k < stream.stamps_ns.size(); ++k) {
      delays.push_back(seconds_between(stream.stamps_ns[k], stream.recorded_ns[k]));
    }
    out.median_delay_s = upper_median(std::move(delays));
  }
  if (stream.first_image) {
    const EncodedImage& image = stream.first_image->image;
    out.images = stream.kind == MessageKind::kImage
                     ? fmt::format("{} x {} {}", image.width, image.height, image.encoding)
                     : stream.first_image->format;
  }
  return out;
}

/// What one notices in the times of a stream.
void note_times(const StreamInfo& stream, std::vector<std::string>& notes) {
  const Timing& timing = stream.timing;
  if (stream.unreadable > 0) {
    notes.push_back(
        fmt::format("{}: {} of {} messages cannot be read", stream.name, stream.unreadable, stream.messages));
  }
  if (stream.unstamped > 0) {
    notes.push_back(
        fmt::format("{}: {} of {} messages have no stamp", stream.name, stream.unstamped, stream.messages));
  }
  if (stream.role.empty()) {
    return;
  }
  if (stream.other_images > 0) {
    notes.push_back(fmt::format("{}: {} of {} images differ from the others in size or encoding", stream.name,
                                stream.other_images, stream.messages));
  }
  if (!stream.stamped) {
    notes.push_back(stream.name + ": the headers have no stamps, these are the times of recording");
  }
  if (timing.gaps > 0) {
    notes.push_back(fmt::format("{}: {} gaps, the longest {:.3f} s at {} ns", stream.name, timing.gaps,
                                timing.longest_gap_s, timing.longest_gap_at_ns));
  }
  if (timing.backward > 0) {
    notes.push_back(fmt::format("{}: the stamps go back {} times, by up to {:.6f} s{}", stream.name,
                                timing.backward, timing.largest_step_back_s,
                                timing.largest_step_back_s > 1.0 ? ": the clock has jumped" : ""));
  }
  if (timing.repeated > 0) {
    notes.push_back(fmt::format("{}: {} stamps come twice", stream.name, timing.repeated));
  }
  if (stream.median_delay_s && std::abs(*stream.median_delay_s) > 1.0) {
    notes.push_back(fmt::format(
        "{}: stamped {:.3f} s {} the time of recording: by another clock than the "
        "recorder's; the stamps count",
        stream.name, std::abs(*stream.median_delay_s), *stream.median_delay_s > 0.0 ? "before" : "after"));
  }
}

const StreamInfo* with_role(const RecordingInfo& info, std::string_view role) {
  const auto found = std::find_if(info.streams.begin(), info.streams.end(),
                                  [&](const StreamInfo& stream) { return stream.role == role; });
  return found == info.streams.end() ? nullptr : &*found;
}

void note_clocks(RecordingInfo& info) {
  const StreamInfo* left = with_role(info, "left");
  for (const char* role : {"imu", "odometry", "truth"}) {
    const StreamInfo* other = with_role(info, role);
    if (left == nullptr || other == nullptr || left->timing.count == 0 || other->timing.count == 0) {
      continue;
    }
    const Timing &a = left->timing, &b = other->timing;
    if (a.first_ns > b.last_ns || b.first_ns > a.last_ns) {
      info.notes.push_back(fmt::format("{} and {} do not overlap in time: {} to {} ns, {} to {} ns",
                                       left->name, other->name, a.first_ns, a.last_ns, b.first_ns,
                                       b.last_ns));
    }
  }
}

void say_what_can_be_done(RecordingInfo& info) {
  const bool frames = info.stereo.has_value() || with_role(info, "tracks") != nullptr;
  const bool imu = with_role(info, "imu") != nullptr, odometry = with_role(info, "odometry") != nullptr;
  const std::string calib = info.calibration ? "" : " --calib camchain.yaml --imu imu.yaml";
  if (!frames) {
    info.missing.push_back("run, health, smooth: no stereo images that limber can tell are left and right");
  } else {
    info.possible.push_back(fmt::format("limber health {}{}", info.path.string(), calib));
    info.possible.push_back(fmt::format("limber run {}{} --out runs/NAME", info.path.string(), calib));
    if (!info.calibration) {
      info.notes.push_back("the bag holds no calibration that is read: --calib gives it");
    }
    if (!imu && !odometry) {
      info.missing.push_back(
          "scale and gravity: neither IMU nor odometry; the baseline alone gives the scale");
    }
  }
  if (with_role(info, "truth") == nullptr) {
    info.missing.push_back("errors against the truth: no topic of true poses");
  }
}

RecordingInfo inspect_bag(const fs::path& path, const std::function<void(std::size_t)>& progress) {
  RecordingInfo info;
  info.path = path;
  auto bag = open_bag(path);
  const BagContents contents = scan_bag(*bag, {}, progress);
  info.format = contents.format;
  info.notes = contents.damages;
  const TopicProposal proposal = propose_topics(contents);
  info.topics = proposal.topics;
  info.notes.insert(info.notes.end(), proposal.notes.begin(), proposal.notes.end());
  const BagStream *left = nullptr, *right = nullptr;
  for (const BagStream& stream : contents.streams) {
    info.streams.push_back(info_of(stream, info.topics));
    note_times(info.streams.back(), info.notes);
    left = stream.topic.name == info.topics.left ? &stream : left;
    right = stream.topic.name == info.topics.right ? &stream : right;
  }
  if (left != nullptr && right != nullptr) {
    const detail::StereoStreams stereo = detail::pair_streams(*left, *right);
    const std::size_t pairs = stereo.paired.pairs.size();
    info.stereo = StereoInfo{pairs, stereo.stamps_ns[0].size() - pairs, stereo.stamps_ns[1].size() - pairs,
                             stereo.paired.median_difference_s, stereo.paired.spread_s};
    if (pairs > 0) {
      const auto images = detail::bag_images(path, std::move(bag), *left, *right, stereo);
      (void)images->find_bits();
      info.images = images;
    }
  }
  note_clocks(info);
  say_what_can_be_done(info);
  return info;
}

template <typename Samples>
void add_stream(RecordingInfo& info, const std::string& name, const std::string& role,
                const Samples& samples) {
  if (samples.empty()) {
    return;
  }
  StreamInfo& stream = info.streams.emplace_back();
  stream.name = stream.type = name;
  stream.role = role;
  stream.timing = timing_of(detail::times_of(samples));
  stream.messages = samples.size();
}

void require_size(const fs::path& image, const Camera& camera) {
  const detail::ImageSize size = detail::read_image_size(image);
  if (size.width != camera.width || size.height != camera.height) {
    throw DataError(image.string(), 0, fmt::format("an image of {} x {} px", camera.width, camera.height),
                    fmt::format("{} x {} px", size.width, size.height));
  }
}

/// Looks at the heads of all image files: the images of single frames may be missing, or others.
void note_unlike_files(const Recording& recording, std::vector<std::string>& notes) {
  std::size_t unlike = 0;
  std::string first;
  for (const ImagePair& pair : recording.images) {
    try {
      require_size(pair.cam0, recording.calibration.cam0);
      require_size(pair.cam1, recording.calibration.cam1);
    } catch (const DataError& error) {
      first = unlike++ == 0 ? error.what() : first;
    }
  }
  if (unlike > 0) {
    notes.push_back(
        fmt::format("{} of {} pairs cannot be used, their frames will have no points; the first: {}", unlike,
                    recording.images.size(), first));
  }
}

RecordingInfo inspect_folder(const fs::path& path) {
  const Recording recording = read_recording(path);
  RecordingInfo info;
  info.path = path;
  info.calibration = recording.calibration;
  info.format = recording.images.empty()                                         ? "track log"
                : fs::exists(path / "mav0") || fs::exists(path / "cam0")         ? "EuRoC folder"
                : fs::exists(path / "image_00") || fs::exists(path / "image_02") ? "KITTI raw drive"
                                                                                 : "KITTI folder";
  info.notes = recording.notes;
  const StereoCalibration& calibration = recording.calibration;
  add_stream(info, "left images", "left", recording.images);
  add_stream(info, "right images", "right", recording.images);
  for (StreamInfo& stream : info.streams) {
    const Camera& camera = stream.role == "left" ? calibration.cam0 : calibration.cam1;
    stream.images = fmt::format("{} x {}", camera.width, camera.height);
  }
  add_stream(info, "matched points", "tracks", recording.frames);
  add_stream(info, "IMU", "imu", recording.imu);
  add_stream(info, "odometry", "odometry", recording.odometry);
  add_stream(info, "true poses", "truth", recording.truth.motion.states);
  for (const StreamInfo& stream : info.streams) {
    note_times(stream, info.notes);
  }
  if (!recording.images.empty()) {
    info.stereo = StereoInfo{recording.images.size(), 0, 0, 0.0, 0.0};
    info.images = stored_images(recording);
    note_unlike_files(recording, info.notes);
  }
  note_clocks(info);
  say_what_can_be_done(info);
  return info;
}

}  // namespace

RecordingInfo inspect(const fs::path& path, const std::function<void(std::size_t)>& progress) {
  return is_bag(path) ? inspect_bag(path, progress) : inspect_folder(path);
}

}  // namespace limber
