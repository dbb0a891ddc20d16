// SPDX-License-Identifier: MIT
#include "bag_images.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "limber/core/errors.hpp"

namespace limber::detail {

BagImages::BagImages(std::filesystem::path path, std::unique_ptr<BagFile> bag, std::array<Camera, 2> cameras)
    : path_(std::move(path)), bag_(std::move(bag)), cameras_(std::move(cameras)) {}

EncodedImage BagImages::load(std::size_t camera, std::size_t pair) const {
  const Camera& from = cameras_.at(camera);
  std::vector<std::uint8_t> message;
  {
    const std::lock_guard lock(reading_);
    message = bag_->read(from.places.at(pair));
  }
  auto image = take_image(std::move(message), from.serialization, from.kind);
  if (!image) {
    throw DataError(place(camera, pair), 0, "an image", "another message: the bag has changed");
  }
  image->bits = bits_;
  return *std::move(image);
}

std::string BagImages::place(std::size_t camera, std::size_t pair) const {
  const Camera& from = cameras_.at(camera);
  return fmt::format("{}, topic {}, {} ns", path_.string(), from.topic, from.stamps_ns.at(pair));
}

int BagImages::find_bits() {
  constexpr std::size_t kLooked = 8;
  const std::size_t looked = std::min(kLooked, pairs());
  unsigned brightest = 0;
  bool any_of_sixteen = false;
  for (std::size_t k = 0; k < looked; ++k) {
    EncodedImage image;
    try {
      image = load(k % 2, k * pairs() / looked);
    } catch (const DataError&) {  // a damaged one says nothing
      continue;
    }
    if (!image.encoding.ends_with("16") && image.encoding != "16UC1") {
      continue;
    }
    any_of_sixteen = true;
    for (std::size_t b = 0; b + 1 < image.data.size(); b += 2) {
      const unsigned first = image.data[b], second = image.data[b + 1];
      brightest = std::max(brightest, image.big_endian ? first << 8 | second : second << 8 | first);
    }
  }
  if (!any_of_sixteen) {
    return 0;
  }
  bits_ = 8;
  while (bits_ < 16 && brightest >> bits_ != 0) {
    ++bits_;
  }
  return bits_;
}

std::vector<std::size_t> order_by_stamp(const BagStream& stream) {
  const auto& stamps = stream.stamps_ns;
  std::vector<std::size_t> order(stamps.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return stamps[a] < stamps[b]; });
  const auto same = [&](std::size_t a, std::size_t b) { return stamps[a] == stamps[b]; };
  order.erase(std::unique(order.begin(), order.end(), same), order.end());
  return order;
}

StereoStreams pair_streams(const BagStream& left, const BagStream& right) {
  StereoStreams out;
  const BagStream* const streams[] = {&left, &right};
  for (std::size_t c = 0; c < 2; ++c) {
    out.order[c] = order_by_stamp(*streams[c]);
    for (const std::size_t k : out.order[c]) {
      out.stamps_ns[c].push_back(streams[c]->stamps_ns[k]);
    }
  }
  out.paired = pair_times(out.stamps_ns[0], out.stamps_ns[1]);
  return out;
}

std::shared_ptr<BagImages> bag_images(const std::filesystem::path& path, std::unique_ptr<BagFile> bag,
                                      const BagStream& left, const BagStream& right,
                                      const StereoStreams& streams) {
  const BagStream* const from[] = {&left, &right};
  std::array<BagImages::Camera, 2> cameras;
  for (std::size_t c = 0; c < 2; ++c) {
    cameras[c] = {from[c]->topic.name, from[c]->topic.serialization, from[c]->kind, {}, {}};
    for (const auto& pair : streams.paired.pairs) {
      const std::size_t k = c == 0 ? pair.first : pair.second;
      cameras[c].places.push_back(from[c]->places[streams.order[c][k]]);
      cameras[c].stamps_ns.push_back(streams.stamps_ns[c][k]);
    }
  }
  return std::make_shared<BagImages>(path, std::move(bag), std::move(cameras));
}

}  // namespace limber::detail
