// SPDX-License-Identifier: MIT
#include <algorithm>
#include <utility>

#include "limber/bags/bag_contents.hpp"

namespace limber {
namespace {

constexpr std::size_t kEnough = 4096;  // bytes before the pixels of an image, and of every other message

bool same_form(const ImageHeader& a, const ImageHeader& b) {
  return a.image.width == b.image.width && a.image.height == b.image.height &&
         a.image.encoding == b.image.encoding && a.format == b.format;
}

/// The first image of a stream that is not like its first one, and how many are like that.
struct OtherForm {
  std::optional<ImageHeader> image;
  std::size_t count = 0;
};

/// Where a stream begins with an image unlike most: those count.
void go_by_most(BagStream& stream, OtherForm other) {
  if (2 * other.count > stream.places.size()) {
    stream.first_image = std::move(other.image);
    stream.other_images = stream.places.size() - other.count;
  }
}

bool take_image(BagStream& stream, OtherForm& other, const BagMessage& message) {
  auto header = decode_image_header(message.data, stream.topic.serialization, stream.kind);
  if (!header || header->data_at + header->data_size > message.place.size) {
    return false;
  }
  stream.stamps_ns.push_back(header->t_ns);
  stream.places.push_back(message.place);
  if (!stream.first_image) {
    stream.first_image = std::move(header);
  } else if (!same_form(*stream.first_image, *header)) {
    ++stream.other_images;
    if (!other.image)
      other.image = std::move(header);
    else if (!same_form(*other.image, *header))
      return true;
    ++other.count;
  }
  return true;
}

/// Puts a decoded message, if it is one, and its time.
template <typename Message>
bool put(std::optional<Message> message, std::vector<Message>& out, std::vector<std::int64_t>& stamps,
         std::int64_t t_ns) {
  if (message) {
    out.push_back(*message);
    stamps.push_back(t_ns);
  }
  return message.has_value();
}

bool take(BagStream& stream, OtherForm& other, const BagMessage& message) {
  const Serialization serialization = stream.topic.serialization;
  switch (stream.kind) {
    case MessageKind::kImage:
    case MessageKind::kCompressedImage:
      return take_image(stream, other, message);
    case MessageKind::kImu: {
      const auto imu = decode_imu(message.data, serialization);
      return put(imu, stream.imu, stream.stamps_ns, imu ? imu->sample.t_ns : 0);
    }
    case MessageKind::kPose: {
      const auto pose = decode_pose(message.data, stream.topic);
      return put(pose, stream.poses, stream.stamps_ns, pose ? pose->t_ns : 0);
    }
    case MessageKind::kTwist: {
      const auto twist = decode_twist(message.data, serialization);
      return put(twist, stream.twists, stream.stamps_ns, twist ? twist->t_ns : 0);
    }
    case MessageKind::kOdometry: {
      const auto odometry = decode_odometry(message.data, serialization);
      if (odometry) {
        stream.poses.push_back(odometry->pose);
        stream.twists.push_back(odometry->twist);
        stream.stamps_ns.push_back(odometry->pose.t_ns);
      }
      return odometry.has_value();
    }
    case MessageKind::kOther:
      break;
  }
  stream.stamps_ns.push_back(message.t_ns);
  return true;
}

/// Headers that nobody has stamped: the time of recording is all there is.
void fall_back_on_bag_time(BagStream& stream) {
  if (stream.kind == MessageKind::kOther) {
    stream.stamped = false;
    return;
  }
  const auto is_zero = [](std::int64_t t_ns) { return t_ns == 0; };
  if (stream.stamps_ns.empty() || !std::all_of(stream.stamps_ns.begin(), stream.stamps_ns.end(), is_zero)) {
    return;
  }
  stream.stamped = false;
  stream.stamps_ns = stream.recorded_ns;
  for (std::size_t k = 0; k < stream.stamps_ns.size(); ++k) {
    const std::int64_t t_ns = stream.stamps_ns[k];
    if (!stream.imu.empty()) stream.imu[k].sample.t_ns = t_ns;
    if (!stream.poses.empty()) stream.poses[k].t_ns = t_ns;
    if (!stream.twists.empty()) stream.twists[k].t_ns = t_ns;
  }
}

/// Takes out messages of time 0 between others: a driver has not stamped them. A simulator's clock may begin
/// at 0, but does not leap from there.
void leave_out_unstamped(BagStream& stream) {
  constexpr std::int64_t kDay = 86'400'000'000'000;  // [ns]
  const std::vector<std::int64_t> stamps = stream.stamps_ns;
  if (std::any_of(stamps.begin(), stamps.end(), [](auto t_ns) { return t_ns != 0 && t_ns < kDay; })) {
    return;
  }
  stream.unstamped = static_cast<std::size_t>(std::count(stamps.begin(), stamps.end(), 0));
  const auto keep_stamped = [&](auto& of_each) {
    std::size_t kept = 0;
    for (std::size_t k = 0; k < of_each.size(); ++k) {
      if (stamps[k] != 0) {
        of_each[kept++] = of_each[k];
      }
    }
    of_each.resize(kept);
  };
  keep_stamped(stream.stamps_ns);
  keep_stamped(stream.recorded_ns);
  keep_stamped(stream.places);
  keep_stamped(stream.imu);
  keep_stamped(stream.poses);
  keep_stamped(stream.twists);
}

}  // namespace

BagContents scan_bag(BagFile& bag, const std::function<bool(const BagTopic&)>& wanted,
                     const std::function<void(std::size_t)>& progress) {
  constexpr std::size_t kTellEvery = 1000;
  BagContents out;
  std::vector<bool> taken;
  std::vector<OtherForm> other_forms;
  std::size_t messages = 0;
  const auto is_wanted = [&](const BagTopic& topic) { return !wanted || wanted(topic); };
  const auto add_streams = [&] {
    for (std::size_t k = out.streams.size(); k < bag.topics().size(); ++k) {
      const BagTopic& topic = bag.topics()[k];
      out.streams.emplace_back().topic = topic;
      out.streams.back().kind = kind_of(topic);
      taken.push_back(is_wanted(topic));
      other_forms.emplace_back();
    }
  };
  bag.walk(
      [&](const BagTopic& topic) {
        return kind_of(topic) != MessageKind::kOther && is_wanted(topic) ? kEnough : 0;
      },
      [&](const BagMessage& message) {
        add_streams();
        BagStream& stream = out.streams[message.topic];
        ++stream.messages;
        if (taken[message.topic]) {
          if (take(stream, other_forms[message.topic], message)) {
            stream.recorded_ns.push_back(message.t_ns);
          } else {
            ++stream.unreadable;
          }
        }
        if (progress && ++messages % kTellEvery == 0) {
          progress(messages);
        }
      });
  add_streams();
  for (std::size_t k = 0; k < out.streams.size(); ++k) {
    BagStream& stream = out.streams[k];
    go_by_most(stream, std::move(other_forms[k]));
    fall_back_on_bag_time(stream);
    leave_out_unstamped(stream);
  }
  out.format = bag.format();
  out.damages = bag.damages();
  out.whole = bag.is_whole();
  return out;
}

}  // namespace limber
