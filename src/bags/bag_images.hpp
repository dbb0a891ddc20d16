// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "limber/bags/bag_contents.hpp"

namespace limber::detail {

/// The stereo images of a bag.
class BagImages final : public ImageStore {
 public:
  struct Camera {
    std::string topic;
    Serialization serialization = Serialization::kOther;
    MessageKind kind = MessageKind::kImage;
    std::vector<BagPlace> places;         ///< one a pair
    std::vector<std::int64_t> stamps_ns;  ///< one a pair
  };

  BagImages(std::filesystem::path path, std::unique_ptr<BagFile> bag, std::array<Camera, 2> cameras);

  [[nodiscard]] EncodedImage load(std::size_t camera, std::size_t pair) const override;
  [[nodiscard]] std::string place(std::size_t camera, std::size_t pair) const override;
  [[nodiscard]] std::size_t pairs() const { return cameras_[0].places.size(); }

  /// Finds out how many bits cameras with pixels of 16 really use, from a few images, and tells load().
  /// @return the bits; 0 if the pixels have not 16
  int find_bits();

 private:
  std::filesystem::path path_;
  mutable std::mutex reading_;
  std::unique_ptr<BagFile> bag_;
  std::array<Camera, 2> cameras_;
  int bits_ = 16;
};

/// Messages of two streams of images by rising stamp, each stamp once, and their pairs.
struct StereoStreams {
  std::array<std::vector<std::size_t>, 2> order;       ///< indices into the streams
  std::array<std::vector<std::int64_t>, 2> stamps_ns;  ///< in this order
  PairedTimes paired;                                  ///< indices into stamps_ns
};
[[nodiscard]] StereoStreams pair_streams(const BagStream& left, const BagStream& right);

/// Indices of a stream's messages by rising stamp, each stamp once.
[[nodiscard]] std::vector<std::size_t> order_by_stamp(const BagStream& stream);

/// Takes the bag over. @param streams  pair_streams(left, right)
[[nodiscard]] std::shared_ptr<BagImages> bag_images(const std::filesystem::path& path,
                                                    std::unique_ptr<BagFile> bag, const BagStream& left,
                                                    const BagStream& right, const StereoStreams& streams);

}  // namespace limber::detail
