// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>

#include "limber/datasets/recording.hpp"
#include "limber/frontend/image_reader.hpp"

namespace limber::app {

/// The stereo pairs of a recording as grey images, from files or from a bag.
class PairReader {
 public:
  /// @param recording  must outlive the reader
  explicit PairReader(const Recording& recording)
      : recording_(recording),
        readers_{ImageReader(recording.calibration.cam0), ImageReader(recording.calibration.cam1)} {}

  /// @throws DataError
  std::array<GreyPixels, 2> read(std::size_t pair) {
    if (recording_.image_store != nullptr) {
      return {stored(0, pair), stored(1, pair)};
    }
    const ImagePair& files = recording_.images[pair];
    return {readers_[0].read(files.cam0), readers_[1].read(files.cam1)};
  }

 private:
  [[nodiscard]] GreyPixels stored(std::size_t camera, std::size_t pair) {
    const ImageStore& store = *recording_.image_store;
    return readers_[camera].read(store.load(camera, pair), store.place(camera, pair));
  }

  const Recording& recording_;
  std::array<ImageReader, 2> readers_;
};

}  // namespace limber::app
