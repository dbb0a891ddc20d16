// SPDX-License-Identifier: MIT
#include "frame_source.hpp"

#include <fmt/format.h>

#include <array>
#include <chrono>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "interrupt.hpp"
#ifdef LIMBER_WITH_FRONTEND
#include "limber/core/errors.hpp"
#include "limber/datasets/image_files.hpp"
#include "limber/frontend/stereo_tracker.hpp"
#include "pair_reader.hpp"
#include "read_ahead.hpp"
#endif

namespace limber::app {
#ifdef LIMBER_WITH_FRONTEND
namespace {

double ms_since(std::chrono::steady_clock::time_point begin) {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
}

template <typename Item>
using Take = std::function<Item(std::size_t)>;

struct DecodedPair {
  std::optional<std::array<GreyPixels, 2>> pixels;
  std::string unreadable;  ///< why there are none; empty: they were read
  double decode_ms = 0.0;
};

/// Reads the images of a recording, one pair after the other.
class PairDecoding {
 public:
  explicit PairDecoding(const Recording& recording) : pairs_(recording.images.size()), reader_(recording) {}

  /// Nothing of a damaged pair. @throws DataError where the first pairs are all so: it is not damage then
  DecodedPair operator()(std::size_t n) {
    DecodedPair result;
    const auto begin = std::chrono::steady_clock::now();
    try {
      result.pixels = reader_.read(n);
      any_read_ = true;
    } catch (const DataError& error) {
      if (!any_read_ && (++unread_ == kFirstPairs || n + 1 == pairs_)) {
        throw;
      }
      result.unreadable = error.what();
    }
    result.decode_ms = ms_since(begin);
    return result;
  }

 private:
  std::size_t pairs_;
  PairReader reader_;
  bool any_read_ = false;
  std::size_t unread_ = 0;
};

/// A frame, and what it took.
struct TrackedFrame {
  StereoFrame frame;
  double decode_ms = 0.0, track_ms = 0.0;
  std::string unreadable;  ///< why it has no points; empty: its images were read
};

/// Tracks the images of a recording, one pair after the other.
class PairTracking {
 public:
  PairTracking(const Recording& recording, const TrackerOptions& options, Take<DecodedPair> decoded)
      : recording_(recording), tracker_(recording.calibration, options), decoded_(std::move(decoded)) {}

  /// Of a pair that cannot be read no points; they are tracked from the pair before into the next one.
  TrackedFrame operator()(std::size_t n) {
    DecodedPair pair = decoded_(n);
    TrackedFrame result{{.t_ns = recording_.images[n].t_ns}, pair.decode_ms, 0.0, std::move(pair.unreadable)};
    if (pair.pixels) {
      const auto begin = std::chrono::steady_clock::now();
      const auto& [left, right] = *pair.pixels;
      result.frame = tracker_.process(result.frame.t_ns, left.view(), right.view());
      result.track_ms = ms_since(begin);
    }
    return result;
  }

 private:
  const Recording& recording_;
  StereoTracker tracker_;
  Take<DecodedPair> decoded_;
};

constexpr std::size_t kDecodedAhead = 4;
/// Points are small, and a start computes for a second before it takes the next frame.
constexpr std::size_t kTrackedAhead = 64;

/// The same items, made on a thread of their own.
template <typename Item>
Take<Item> made_ahead(Take<Item> make, std::size_t count, std::size_t most_ahead) {
  auto ahead = std::make_shared<ReadAhead<Item>>(std::move(make), count, most_ahead);
  return [ahead](std::size_t n) { return ahead->take(n); };
}

Take<TrackedFrame> tracked_frames(const Recording& recording, const FrontendArguments& arguments) {
  TrackerOptions options;
  options.max_tracks = arguments.max_tracks;
  const std::size_t pairs = recording.images.size();
  auto decoding = std::make_shared<PairDecoding>(recording);
  Take<DecodedPair> decoded = [decoding](std::size_t n) { return (*decoding)(n); };
  if (arguments.threads > 2) {
    decoded = made_ahead(std::move(decoded), pairs, kDecodedAhead);
  }
  auto tracking = std::make_shared<PairTracking>(recording, options, std::move(decoded));
  Take<TrackedFrame> tracked = [tracking](std::size_t n) { return (*tracking)(n); };
  return arguments.threads > 1 ? made_ahead(std::move(tracked), pairs, kTrackedAhead) : tracked;
}

/// Keeps the frames that were taken, one after the other, for those who take them again.
class KeptFrames {
 public:
  explicit KeptFrames(Take<TrackedFrame> take) : take_(std::move(take)) {}

  TrackedFrame operator()(std::size_t n, FrontendRecord& record) {
    if (kept_.empty()) first_ = n;
    const std::size_t k = n - first_;
    if (k > kept_.size()) throw std::logic_error("KeptFrames: the frames begin elsewhere, or with a gap");
    if (k == kept_.size()) {
      kept_.push_back(take_(n));
    } else {
      record.earlier_ms += kept_[k].decode_ms + kept_[k].track_ms;
    }
    return kept_[k];
  }

 private:
  Take<TrackedFrame> take_;
  std::size_t first_ = 0;
  std::vector<TrackedFrame> kept_;
};

/// Frames as `take` makes them, with what it took.
template <typename TakeAndRecord>
ImageFrames recorded(TakeAndRecord take) {
  auto record = std::make_shared<FrontendRecord>();
  auto damaged = std::make_shared<DamagedPairs>();
  return {[take, record, damaged](std::size_t n) {
            TrackedFrame tracked = take(n, *record);
            record->add(tracked.frame, tracked.decode_ms, tracked.track_ms);
            ++damaged->frames;
            if (!tracked.unreadable.empty()) {
              damaged->why.push_back(fmt::format("at {} ns: {}", tracked.frame.t_ns, tracked.unreadable));
            }
            return std::move(tracked.frame);
          },
          record, damaged};
}

}  // namespace
#endif

RepeatedFrames repeated_frames(const Recording& recording, const FrontendArguments& arguments) {
  if (recording.images.empty()) {
    return [&recording] { return ImageFrames{matched_frames(recording)}; };
  }
#ifdef LIMBER_WITH_FRONTEND
  auto kept = std::make_shared<KeptFrames>(tracked_frames(recording, arguments));
  return [kept] {
    return recorded([kept](std::size_t n, FrontendRecord& record) { return (*kept)(n, record); });
  };
#else
  return [&recording, arguments] { return image_frames(recording, arguments); };
#endif
}

ImageFrames image_frames(const Recording& recording, [[maybe_unused]] const FrontendArguments& arguments) {
  if (recording.images.empty()) {
    return {matched_frames(recording)};
  }
#ifdef LIMBER_WITH_FRONTEND
  return recorded(
      [take = tracked_frames(recording, arguments)](std::size_t n, FrontendRecord&) { return take(n); });
#else
  throw std::runtime_error(recording.name +
                           " holds images, but this program was built without the image front end");
#endif
}

FrameSource stoppable(FrameSource frames) {
  return [frames = std::move(frames)](std::size_t n) {
    Interrupt::check();
    return frames(n);
  };
}

bool note_damaged(const ImageFrames& source, std::vector<std::string>& notes) {
  if (!source.damaged || source.damaged->why.empty()) {
    return false;
  }
  notes.push_back(
      fmt::format("the images of {} of {} frames cannot be read: these have no points; the first, {}",
                  source.damaged->why.size(), source.damaged->frames, source.damaged->why.front()));
  return true;
}

void add_damaged(const ImageFrames& source, RunRecord& record) {
  if (note_damaged(source, record.notes)) {
    record.recording_partial = true;
    record.frames_unreadable = source.damaged->why.size();
  }
}

}  // namespace limber::app
