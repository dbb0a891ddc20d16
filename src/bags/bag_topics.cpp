// SPDX-License-Identifier: MIT
#include "limber/bags/bag_topics.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <stdexcept>
#include <utility>

#include "limber/core/nearest_word.hpp"
#include "limber/core/split.hpp"

namespace limber {
namespace {

using Member = std::string BagTopics::*;
constexpr std::array<std::pair<std::string_view, Member>, 5> kRoles = {{{"left", &BagTopics::left},
                                                                        {"right", &BagTopics::right},
                                                                        {"imu", &BagTopics::imu},
                                                                        {"odometry", &BagTopics::odometry},
                                                                        {"truth", &BagTopics::truth}}};

/// What tells a left name from a right one, the most telling first.
constexpr std::array<std::pair<std::string_view, std::string_view>, 5> kSides = {
    {{"left", "right"}, {"cam0", "cam1"}, {"infra1", "infra2"}, {"0", "1"}, {"1", "2"}}};

bool holds(const std::string& name, std::string_view word) {
  return in_lower_case(name).find(word) != std::string::npos;
}

template <typename Words>
bool holds_any(const std::string& name, const Words& words) {
  return std::any_of(words.begin(), words.end(), [&](std::string_view word) { return holds(name, word); });
}

/// Encodings that depth is sent in.
bool is_depth(std::string_view encoding) { return encoding == "16UC1" || encoding == "32FC1"; }

bool is_picture(const BagStream& stream) {
  constexpr std::array<std::string_view, 6> kNoPictures = {"depth",     "disparity",    "mask",
                                                           "thumbnail", "segmentation", "confidence"};
  if (stream.places.empty() || holds_any(stream.topic.name, kNoPictures)) {
    return false;
  }
  return !is_depth(stream.first_image->image.encoding);
}

void note_depth(const BagContents& contents, TopicProposal& proposal) {
  for (const BagStream& stream : contents.streams) {
    if (stream.first_image && is_depth(stream.first_image->image.encoding)) {
      proposal.notes.push_back(fmt::format("{}: {} is how depth is sent, it is taken for no picture",
                                           stream.topic.name, stream.first_image->image.encoding));
    }
  }
}

struct Pair {
  const BagStream* left;
  const BagStream* right;
  std::size_t side;  ///< of kSides
};

/// Small is good.
auto rank(const Pair& pair) {
  const std::string& name = pair.left->topic.name;
  return std::make_tuple(
      pair.left->kind == MessageKind::kCompressedImage, pair.side, holds(name, "rect"),
      -static_cast<std::ptrdiff_t>(std::min(pair.left->places.size(), pair.right->places.size())), name);
}

/// Whether the right name is the left one with the first, or every, `side.first` replaced.
bool is_partner(const std::string& left, const std::string& right,
                const std::pair<std::string_view, std::string_view>& side) {
  const std::size_t first = left.find(side.first);
  if (first == std::string::npos) {
    return false;
  }
  const std::string_view text = left;
  std::string one, all;
  one.append(text.substr(0, first)).append(side.second).append(text.substr(first + side.first.size()));
  std::size_t done = 0;
  for (std::size_t at = first; at != std::string::npos; at = text.find(side.first, done)) {
    all.append(text.substr(done, at - done)).append(side.second);
    done = at + side.first.size();
  }
  all.append(text.substr(done));
  return all == right || one == right;
}

std::vector<Pair> stereo_pairs(const BagContents& contents) {
  std::vector<Pair> out;
  for (const BagStream& left : contents.streams) {
    for (const BagStream& right : contents.streams) {
      if (left.kind != right.kind || !is_picture(left) || !is_picture(right)) {
        continue;
      }
      for (std::size_t side = 0; side < kSides.size(); ++side) {
        if (is_partner(left.topic.name, right.topic.name, kSides[side])) {
          out.push_back({&left, &right, side});
          break;
        }
      }
    }
  }
  std::sort(out.begin(), out.end(), [](const Pair& a, const Pair& b) { return rank(a) < rank(b); });
  return out;
}

void propose_images(const BagContents& contents, TopicProposal& proposal) {
  std::vector<Pair> pairs = stereo_pairs(contents);
  if (pairs.empty()) {
    std::vector<const BagStream*> pictures;
    for (const BagStream& stream : contents.streams) {
      if (is_picture(stream)) {
        pictures.push_back(&stream);
      }
    }
    if (pictures.size() != 2) {
      note_depth(contents, proposal);
      return;
    }
    std::sort(pictures.begin(), pictures.end(),
              [](const auto* a, const auto* b) { return a->topic.name < b->topic.name; });
    pairs.push_back({pictures[0], pictures[1], 0});
    proposal.notes.push_back(fmt::format(
        "the names do not say which camera is the left one: {} is taken for it", pictures[0]->topic.name));
  }
  proposal.topics.left = pairs.front().left->topic.name;
  proposal.topics.right = pairs.front().right->topic.name;
  if (pairs.size() > 1) {
    std::string others;
    for (std::size_t k = 1; k < pairs.size(); ++k) {
      others += fmt::format("{}{} and {}", k == 1 ? "" : "; ", pairs[k].left->topic.name,
                            pairs[k].right->topic.name);
    }
    proposal.notes.push_back("other stereo pairs: " + others);
  }
  if (holds(proposal.topics.left, "rect")) {
    proposal.notes.push_back("by their name these images are rectified: so must be their calibration");
  }
}

/// The stream with the most messages among those that `fits` takes; the others are noted.
template <typename Fits>
std::string most_of(const BagContents& contents, const char* what, TopicProposal& proposal, Fits fits) {
  const BagStream* best = nullptr;
  std::string others;
  for (const BagStream& stream : contents.streams) {
    if (!fits(stream)) {
      continue;
    }
    const BagStream* other = &stream;
    if (best == nullptr || stream.stamps_ns.size() > best->stamps_ns.size()) {
      std::swap(best, other);
    }
    if (other != nullptr) {
      others += (others.empty() ? "" : ", ") + other->topic.name;
    }
  }
  if (!others.empty()) {
    proposal.notes.push_back(fmt::format("other topics that could be {}: {}", what, others));
  }
  return best == nullptr ? "" : best->topic.name;
}

}  // namespace

BagTopics parse_bag_topics(std::string_view text) {
  BagTopics out;
  for (const std::string_view item : split(text, ',')) {
    const std::size_t equals = item.find('=');
    const std::string_view name = item.substr(0, equals);
    const auto role =
        std::find_if(kRoles.begin(), kRoles.end(), [&](const auto& r) { return r.first == name; });
    if (role == kRoles.end() || equals == std::string_view::npos || equals + 1 == item.size() ||
        !(out.*role->second).empty()) {
      const std::vector<std::string> roles = {"left", "right", "imu", "odometry", "truth"};
      throw std::invalid_argument(
          fmt::format("'{}' in '{}': expected left=TOPIC, right=TOPIC, imu=TOPIC, odometry=TOPIC or "
                      "truth=TOPIC, each once{}",
                      item, text, role == kRoles.end() ? did_you_mean(name, roles) : ""));
    }
    out.*role->second = item.substr(equals + 1);
  }
  return out;
}

std::string format_bag_topics(const BagTopics& topics) {
  std::string out;
  for (const auto& [name, member] : kRoles) {
    if (!(topics.*member).empty()) {
      out += fmt::format("{}{}={}", out.empty() ? "" : ",", name, topics.*member);
    }
  }
  return out;
}

TopicProposal propose_topics(const BagContents& contents) {
  constexpr std::array<std::string_view, 9> kTruths = {"truth", "gt",       "vicon", "mocap",    "optitrack",
                                                       "leica", "qualisys", "vrpn",  "reference"};
  TopicProposal out;
  propose_images(contents, out);
  BagTopics& topics = out.topics;
  topics.imu = most_of(contents, "the IMU", out, [](const BagStream& stream) {
    return !stream.imu.empty() && stream.imu.front().has_rates && stream.imu.front().has_accelerations;
  });
  topics.truth = most_of(contents, "the truth", out, [&](const BagStream& stream) {
    return !stream.poses.empty() && holds_any(stream.topic.name, kTruths);
  });
  if (topics.imu.empty()) {
    topics.odometry = most_of(contents, "the odometry", out, [&](const BagStream& stream) {
      return !stream.twists.empty() && stream.topic.name != topics.truth;
    });
  }
  return out;
}

}  // namespace limber
