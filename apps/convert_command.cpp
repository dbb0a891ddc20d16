// SPDX-License-Identifier: MIT
// limber convert: recordings and trajectories between formats.
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cctype>
#include <filesystem>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "commands.hpp"
#include "interrupt.hpp"
#include "limber/bags/bag_topics.hpp"
#include "limber/bags/write_bag.hpp"
#include "limber/bags/write_results.hpp"
#include "limber/core/errors.hpp"
#include "limber/core/nearest_word.hpp"
#include "limber/datasets/recording_place.hpp"
#include "limber/datasets/track_log.hpp"
#include "limber/datasets/trajectory_files.hpp"
#include "limber/datasets/write_euroc.hpp"
#include "limber/run_files/run_results.hpp"
#include "messages.hpp"
#include "output_folder.hpp"
#include "progress.hpp"
#include "recording_options.hpp"
#include "replaceable.hpp"
#include "trajectory_input.hpp"
#include "uninterrupted.hpp"
#include "validators.hpp"
#ifdef LIMBER_WITH_FRONTEND
#include "limber/frontend/decode_image.hpp"
#include "limber/images/picture.hpp"
#endif

namespace limber::app {
namespace {

namespace fs = std::filesystem;

struct ConvertArguments {
  RecordingArguments recording;
  fs::path out;
  std::string pixels = "keep", compression;
  bool force = false;
};

std::string ending_of(const fs::path& path) { return in_lower_case(path.extension().string()); }

const std::vector<std::string> kTrajectories = {".tum", ".txt", ".csv", ".kitti"};
const std::vector<std::string> kBags = {".mcap", ".bag"};
constexpr const char* kEndings =
    "FILE.mcap or FILE.bag (messages), FILE.tum, FILE.txt, FILE.csv or FILE.kitti (poses)";

bool is_one_of(const std::vector<std::string>& endings, const fs::path& out) {
  return std::find(endings.begin(), endings.end(), ending_of(out)) != endings.end();
}

bool is_trajectory(const fs::path& out) { return is_one_of(kTrajectories, out); }

bool is_folder(const fs::path& out) {
  return !is_trajectory(out) && !is_one_of(kBags, out) && !fs::is_regular_file(out);
}

/// "x.pdf" is meant for a file, "data/v1.2" and "x.pdf/" for folders, and so is a folder that is there.
void require_known_ending(const fs::path& out) {
  constexpr std::size_t kLongest = 6;
  const std::string ending = ending_of(out);
  const bool of_a_file = ending.size() > 1 && ending.size() <= kLongest &&
                         std::isalpha(static_cast<unsigned char>(ending[1])) != 0;
  if (of_a_file && !is_trajectory(out) && !is_one_of(kBags, out) && !fs::is_directory(out)) {
    std::vector<std::string> known = kTrajectories;
    known.insert(known.end(), kBags.begin(), kBags.end());
    throw CLI::ValidationError(
        "--out", fmt::format("nothing is written as {}{}: {}; a folder of such a name has a / behind it",
                             ending, did_you_mean(ending, known), kEndings));
  }
}

/// Of a trajectory or a run, nothing but the poses is read.
void refuse_options_of_recordings(const ConvertArguments& arguments) {
  const RecordingArguments& of = arguments.recording;
  const char* const given = !of.calibration.empty()       ? "--calib"
                            : !of.imu.empty()             ? "--imu"
                            : of.readout_time.has_value() ? "--readout-time"
                            : arguments.pixels != "keep"  ? "--pixels"
                                                          : nullptr;
  if (given != nullptr) {
    throw CLI::ValidationError(given, "only a recording has it, and here poses are converted");
  }
}

/// Nothing: --out names no file of messages.
std::optional<BagOutput> bag_output_of(const ConvertArguments& arguments) {
  const std::string ending = ending_of(arguments.out);
  if (ending != ".mcap" && ending != ".bag") {
    if (!arguments.compression.empty()) {
      throw CLI::ValidationError("--compression", "only FILE.mcap and FILE.bag have one");
    }
    return std::nullopt;
  }
  BagOutput output{arguments.out, ending == ".bag" ? BagFormat::kRos1 : BagFormat::kMcap,
                   arguments.compression};
  const auto known = compressions_of(output.format);
  if (!output.compression.empty() &&
      std::find(known.begin(), known.end(), output.compression) == known.end()) {
    throw CLI::ValidationError("--compression",
                               fmt::format("of a {} file is {}", ending, fmt::join(known, ", ")));
  }
  return output;
}

void require_free(const ConvertArguments& arguments) {
  const fs::path& out = arguments.out;
  const RecordingArguments& in = arguments.recording;
  std::error_code ignored;
  if (fs::equivalent(out, in.dataset, ignored) || fs::equivalent(out / "mav0", in.dataset, ignored)) {
    throw DataError(out.string(), 0, "a name for the result that is not also the input", "what is converted");
  }
  if (is_folder(out)) {
    require_no_run(out);
    require_place_for_mav0(out, arguments.force);
  } else {
    require_replaceable(out, kNoMark, arguments.force, {in.dataset, in.calibration, in.imu});
  }
}

#ifdef LIMBER_WITH_FRONTEND
EncodedImage as_grey(const EncodedImage& image, const std::string& place) {
  GreyPixels grey = decode_grey(image, place);
  EncodedImage out;
  out.encoding = "mono8";
  out.width = grey.width;
  out.height = grey.height;
  out.step = static_cast<std::size_t>(grey.width);
  out.data = std::move(grey.data);
  return out;
}

/// The pixels of a file as they are in it, but for alpha.
EncodedImage as_pixels(const EncodedImage& file, const std::string& place) {
  const std::string_view content(reinterpret_cast<const char*>(file.data.data()), file.data.size());
  Picture picture = decode_picture(content, Colours::kKeep, place);
  EncodedImage out;
  out.encoding = std::string(picture.channels == 3 ? "rgb" : "mono") + (picture.bits == 16 ? "16" : "8");
  out.width = picture.width;
  out.height = picture.height;
  out.step = picture.stride();
  out.big_endian = std::endian::native == std::endian::big;
  out.data = std::move(picture.data);
  return out;
}

/// PNG knows neither Bayer patterns nor YUV: these become grey.
std::vector<std::uint8_t> as_png(const EncodedImage& image, const std::string& place) {
  const bool pattern = image.encoding.starts_with("bayer") || image.encoding.starts_with("yu") ||
                       image.encoding.starts_with("uy");
  return encode_png(pattern ? as_grey(image, place) : image, place);
}
#else
[[noreturn]] EncodedImage as_pixels(const EncodedImage&, const std::string&) {
  throw std::runtime_error("this program was built without the image front end, which unpacks images");
}
[[noreturn]] std::vector<std::uint8_t> as_png(const EncodedImage&, const std::string&) {
  throw std::runtime_error("this program was built without the image front end, which packs images");
}
#endif

ImageChange change_of(const std::string& pixels) {
  if (pixels == "raw") {
    return [](EncodedImage image, const std::string& place) {
      return image.encoding.empty() ? as_pixels(image, place) : std::move(image);
    };
  }
  if (pixels == "png") {
    return [](EncodedImage image, const std::string& place) {
      if (!image.encoding.empty()) {
        image.data = as_png(image, place);
        image.encoding.clear();
      }
      return image;
    };
  }
  return {};
}

/// What a format cannot say.
void note_losses(const Recording& recording, bool bag) {
  if (bag) {
    print_note("a file of messages holds no calibration: keep it, --calib gives it to limber run");
  }
  const auto& offsets = recording.calibration.time_offset_s;
  if (!bag && (offsets[0] != 0.0 || offsets[1] != 0.0)) {
    print_warning(fmt::format("an EuRoC folder cannot say that the images are late by {:.6f} s and {:.6f} s",
                              offsets[0], offsets[1]));
  }
}

/// @return whether there are any
bool warn_of(const std::vector<LostImage>& lost) {
  constexpr std::size_t kShown = 10;
  for (std::size_t k = 0; k < std::min(kShown, lost.size()); ++k) {
    print_warning(fmt::format("the image of cam{} at {} ns is left out: {}", lost[k].camera, lost[k].t_ns,
                              lost[k].why));
  }
  if (lost.size() > kShown) {
    print_warning(fmt::format("and {} more images are left out", lost.size() - kShown));
  }
  return !lost.empty();
}

/// @return whether parts of the recording were missing
bool convert_recording(const ConvertArguments& arguments, const std::optional<BagOutput>& bag) {
  const Interrupt interrupt;
  const Recording recording = open_recording(arguments.recording);
  for (const std::string& note : recording.notes) {
    print_note(note);
  }
  if (recording.images.empty()) {
    if (bag) {
      throw std::runtime_error(recording.name +
                               " holds matched points, for which there is no message type: "
                               "give a folder as --out");
    }
    write_track_log(recording, arguments.out, arguments.force);
    return recording.partial;
  }
  Progress progress("convert", recording.images.size());
  const auto done = [&](std::size_t n) { progress.done(n); };
  std::vector<LostImage> lost;
  if (bag) {
    lost = write_bag(recording, *bag, change_of(arguments.pixels), done, Interrupt::asked);
  } else {
    if (arguments.pixels == "raw") {
      throw CLI::ValidationError("--pixels", "an EuRoC folder has image files, no raw pixels");
    }
    lost = write_euroc(recording, arguments.out, as_png, arguments.force, done, Interrupt::asked);
  }
  note_losses(recording, bag.has_value());
  return warn_of(lost) || recording.partial;
}

std::vector<TrajectoryRow> rows_of(const TrajectoryInput& input) {
  std::vector<TrajectoryRow> rows;
  for (const StampedPose& pose : input.poses) {
    TrajectoryRow& row = rows.emplace_back();
    row.t_ns = pose.t_ns;
    row.T_world_body = pose.T_world_body;
    if (!input.covariances.empty() && input.covariances[rows.size() - 1].allFinite()) {
      row.covariance = input.covariances[rows.size() - 1];
    }
  }
  return rows;
}

void convert_trajectory(const ConvertArguments& arguments) {
  const std::string& topics = arguments.recording.topics;
  const TrajectoryInput input = load_poses_to_convert(arguments.recording.dataset,
                                                      topics.empty() ? "" : parse_bag_topics(topics).truth);
  if (!input.topic.empty()) {
    print_note(fmt::format("poses of {}{}", input.topic,
                           topics.empty() ? "; --topics truth=TOPIC takes others" : ""));
  }
  const std::string ending = ending_of(arguments.out);
  if (!input.has_time && ending != ".kitti") {
    throw std::runtime_error(input.path.string() + " has no times, which " + ending + " needs");
  }
  const Uninterrupted until_written;
  if (ending == ".kitti") {
    write_kitti_poses(arguments.out, input.poses);
  } else if (ending == ".csv") {
    write_trajectory_csv(arguments.out, rows_of(input));
  } else {
    write_tum(arguments.out, input.poses);
  }
}

/// In a folder that holds both, the recording counts, as for limber run.
bool is_run_alone(const fs::path& path) { return is_run_folder(path) && !holds_recording(path); }

/// Nothing: what is converted is no run and no trajectory file.
std::optional<RunResults> results_of(const fs::path& path) {
  if (is_run_alone(path)) {
    return read_run_results(path);
  }
  if (!fs::is_regular_file(path) || !is_trajectory(path)) {
    return std::nullopt;
  }
  const TrajectoryInput input = load_trajectory(path);
  if (!input.has_time) {
    throw std::runtime_error(path.string() + " has no times, which messages need");
  }
  return RunResults{rows_of(input), {}, {}, {}};
}

void convert(const ConvertArguments& arguments) {
  require_known_ending(arguments.out);
  require_free(arguments);
  const std::optional<BagOutput> bag = bag_output_of(arguments);
  if (is_folder(arguments.out) && is_run_alone(arguments.recording.dataset)) {
    throw CLI::ValidationError("--out",
                               fmt::format("a run becomes {}, not a folder of a recording", kEndings));
  }
  const std::optional<RunResults> results = bag ? results_of(arguments.recording.dataset) : std::nullopt;
  if (results || is_trajectory(arguments.out)) {
    refuse_options_of_recordings(arguments);
  }
  const ClaimedPlace claimed(arguments.out);
  bool partial = false;
  if (results) {
    if (!arguments.recording.topics.empty()) {
      throw CLI::ValidationError("--topics", "bags have topics, this is none");
    }
    const Uninterrupted until_written;
    write_results(*results, *bag);
  } else if (is_trajectory(arguments.out)) {
    convert_trajectory(arguments);
  } else {
    partial = convert_recording(arguments, bag);
  }
  fmt::print("{}\n", arguments.out.string());
  if (partial) {
    print_warning("written without the parts that are missing, see above");
    throw CLI::RuntimeError(kExitFailed);
  }
}

}  // namespace

void add_convert_command(CLI::App& app) {
  auto arguments = std::make_shared<ConvertArguments>();
  CLI::App* command =
      app.add_subcommand("convert", "Turn recordings, trajectories and results into other formats");
  add_input_options(*command, arguments->recording);
  command
      ->add_option(
          "--out", arguments->out,
          "FOLDER: EuRoC; FILE.mcap (ROS 2 messages), FILE.bag (ROS 1); FILE.tum, .txt (TUM), .csv (limber), "
          ".kitti: poses alone")
      ->required()
      ->check(not_empty());
  command
      ->add_option("--pixels", arguments->pixels,
                   "Images of FILE.mcap and FILE.bag: keep, raw (unpacked) or png (packed)")
      ->transform(one_of({"keep", "raw", "png"}))
      ->capture_default_str();
  command
      ->add_option("--compression", arguments->compression,
                   "Of FILE.mcap: zstd (default), lz4 or none; of FILE.bag: lz4 (default), bz2 or none")
      ->transform(one_of({"zstd", "lz4", "bz2", "none"}));
  add_force_option(*command, arguments->force, "Replace an older result; of folders those that limber wrote");
  command->footer(
      "\nIMU, stamps and images keep every bit; Bayer and YUV images become grey in an EuRoC folder.\n"
      "Of a run's folder a file of messages gets odometry, tf, path, map and diagnostics, of a trajectory "
      "the "
      "first three.\n"
      "Ctrl-C leaves nothing behind. Of a damaged recording what is readable is written, and the exit code "
      "is 1.\n"
      "Example:\n  limber convert flight.bag --calib camchain.yaml --imu imu.yaml --out data/flight\n"
      "  limber convert data/flight --out flight.mcap\n  limber convert data/flight --out copy.bag\n  "
      "limber convert runs/v101/trajectory.csv --out "
      "v101.tum\n  limber convert runs/v101 --out v101.mcap");
  command->callback([arguments] { convert(*arguments); });
}

}  // namespace limber::app
