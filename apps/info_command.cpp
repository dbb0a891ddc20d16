// SPDX-License-Identifier: MIT
// limber info: what is in a recording, and what can be done with it.
#include <fmt/format.h>

#include <array>
#include <filesystem>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>
#include <string>
#include <tuple>
#include <utility>

#include "commands.hpp"
#include "limber/bags/inspect.hpp"
#include "ordered_json.hpp"
#include "progress.hpp"
#include "validators.hpp"
#ifdef LIMBER_WITH_FRONTEND
#include "limber/core/errors.hpp"
#include "limber/frontend/decode_image.hpp"
#include "limber/frontend/image_reader.hpp"
#endif

namespace limber::app {
namespace {

constexpr double kUnlike = 1.5;  // brightness of one camera over the other's

struct InfoArguments {
  std::filesystem::path recording;
  bool json = false;
};

/// Mean grey level of the left and of the right images, over a few pairs.
struct Brightness {
  double left = 0.0, right = 0.0;  ///< 0 to 255
};

#ifdef LIMBER_WITH_FRONTEND
Camera sized(const std::pair<int, int>& width_and_height) {
  Camera camera;
  std::tie(camera.width, camera.height) = width_and_height;
  return camera;
}
#endif

/// Of the images that can be read; the others become a note. Nothing where there are none.
std::optional<Brightness> look_at_images(RecordingInfo& info) {
#ifdef LIMBER_WITH_FRONTEND
  constexpr std::size_t kLooked = 9;
  if (!info.images || !info.stereo || info.stereo->pairs == 0) {
    return std::nullopt;
  }
  const std::size_t looked = std::min(kLooked, info.stereo->pairs);
  std::array<std::map<std::pair<int, int>, ImageReader>, 2> readers;  // by size: most have the same
  const auto mean = [&](std::size_t camera, std::size_t pair) {
    const EncodedImage image = info.images->load(camera, pair);
    const std::string place = info.images->place(camera, pair);
    const auto size = size_of(image, place);
    const GreyPixels grey = readers[camera].try_emplace(size, sized(size)).first->second.read(image, place);
    return static_cast<double>(std::accumulate(grey.data.begin(), grey.data.end(), std::uint64_t{0})) /
           static_cast<double>(grey.data.size());
  };
  Brightness sum;
  std::size_t read = 0;
  std::string unreadable;  // the first
  for (std::size_t k = 0; k < looked; ++k) {
    const std::size_t pair = k * info.stereo->pairs / looked;
    try {
      const double left = mean(0, pair), right = mean(1, pair);
      sum.left += left;
      sum.right += right;
      ++read;
    } catch (const DataError& error) {
      unreadable = unreadable.empty() ? error.what() : unreadable;
    }
  }
  if (!unreadable.empty()) {
    info.notes.push_back(fmt::format("of {} pairs that were looked at {} cannot be read; the first: {}",
                                     looked, looked - read, unreadable));
  }
  if (read == 0) {
    return std::nullopt;
  }
  const auto count = static_cast<double>(read);
  return Brightness{sum.left / count, sum.right / count};
#else
  (void)info;
  return std::nullopt;
#endif
}

void judge_brightness(const std::optional<Brightness>& brightness, RecordingInfo& info) {
  if (!brightness) {
    return;
  }
  const auto [low, high] = std::minmax(brightness->left, brightness->right);
  if (high > kUnlike * low) {
    info.notes.push_back(
        fmt::format("left and right images are not equally exposed: mean grey {:.0f} and {:.0f} of 255, "
                    "which costs matches",
                    brightness->left, brightness->right));
  }
}

nlohmann::ordered_json to_json(const StreamInfo& stream) {
  const Timing& timing = stream.timing;
  const auto or_null = [](bool known, auto value) -> nlohmann::ordered_json {
    return known ? nlohmann::ordered_json(value) : nlohmann::ordered_json();
  };
  return {{"name", stream.name},
          {"type", stream.type},
          {"role", or_null(!stream.role.empty(), stream.role)},
          {"messages", stream.messages},
          {"unreadable", stream.unreadable},
          {"unstamped", stream.unstamped},
          {"first_ns", or_null(timing.count > 0, timing.first_ns)},
          {"last_ns", or_null(timing.count > 0, timing.last_ns)},
          {"rate_hz", or_null(timing.median_interval_s > 0.0, timing.rate_hz())},
          {"gaps", timing.gaps},
          {"longest_gap_s", timing.longest_gap_s},
          {"steps_back", timing.backward},
          {"largest_step_back_s", timing.largest_step_back_s},
          {"repeated_stamps", timing.repeated},
          {"stamped", stream.stamped},
          {"delay_s", or_null(stream.median_delay_s.has_value(), stream.median_delay_s.value_or(0.0))},
          {"images", or_null(!stream.images.empty(), stream.images)}};
}

/// The lens's coefficients by name.
nlohmann::ordered_json lens_json(const Distortion& distortion) {
  nlohmann::ordered_json out = nlohmann::ordered_json::object();
  const auto names = coefficient_names(distortion);
  const auto values = coefficients(distortion);
  for (std::size_t k = 0; k < names.size(); ++k) {
    out[std::string(names[k])] = values[k];
  }
  return out;
}

nlohmann::ordered_json to_json(const Camera& camera) {
  return {{"width", camera.width},
          {"height", camera.height},
          {"fu", camera.fu},
          {"fv", camera.fv},
          {"cu", camera.cu},
          {"cv", camera.cv},
          {"distortion_model", model_name(camera.distortion)},
          {"distortion_coefficients", lens_json(camera.distortion)}};
}

std::string to_json(const RecordingInfo& info, const std::optional<Brightness>& brightness) {
  nlohmann::ordered_json out = {{"path", info.path.string()}, {"format", info.format}};
  out["has_calibration"] = info.calibration.has_value();
  out["cameras"] = nullptr;
  if (info.calibration) {
    out["cameras"] = {to_json(info.calibration->cam0), to_json(info.calibration->cam1)};
  }
  out["streams"] = nlohmann::ordered_json::array();
  for (const StreamInfo& stream : info.streams) {
    out["streams"].push_back(to_json(stream));
  }
  out["stereo"] = nullptr;
  if (info.stereo) {
    const StereoInfo& stereo = *info.stereo;
    out["stereo"] = {{"pairs", stereo.pairs},
                     {"left_alone", stereo.left_alone},
                     {"right_alone", stereo.right_alone},
                     {"median_difference_s", stereo.median_difference_s},
                     {"spread_s", stereo.spread_s},
                     {"synchronised", stereo.synchronised()},
                     {"mean_grey", nullptr}};
    if (brightness) {
      out["stereo"]["mean_grey"] = {brightness->left, brightness->right};
    }
  }
  out["topics"] = format_bag_topics(info.topics);
  out["possible"] = info.possible;
  out["missing"] = info.missing;
  out["notes"] = info.notes;
  return json_text(out);
}

std::string to_text(const StreamInfo& stream) {
  const Timing& timing = stream.timing;
  std::string out = fmt::format("  {:<32} {:<9} {:>8}", stream.name, stream.role, stream.messages);
  out += timing.median_interval_s > 0.0 ? fmt::format(" {:>9.2f} Hz", timing.rate_hz())
                                        : fmt::format(" {:>12}", "");
  out += fmt::format(" {:>9.2f} s  {}", timing.duration_s(), stream.type == stream.name ? "" : stream.type);
  return out + (stream.images.empty() ? "" : (out.ends_with("  ") ? "" : ", ") + stream.images) + "\n";
}

std::string to_text(const char* side, const Camera& camera) {
  std::string lens(model_name(camera.distortion));
  const auto names = coefficient_names(camera.distortion);
  const auto values = coefficients(camera.distortion);
  for (std::size_t k = 0; k < names.size(); ++k) {
    lens += fmt::format(" {}={:.4g}", names[k], values[k]);
  }
  return fmt::format("{:<5}  {} x {} px, f {:.2f} {:.2f}, centre {:.2f} {:.2f}, distortion {}\n", side,
                     camera.width, camera.height, camera.fu, camera.fv, camera.cu, camera.cv, lens);
}

std::string to_text(const RecordingInfo& info, const std::optional<Brightness>& brightness) {
  std::string out = fmt::format("{}: {}\n\n", info.path.string(), info.format);
  out += fmt::format("  {:<32} {:<9} {:>8} {:>12} {:>11}  {}\n", "stream", "role", "messages", "rate",
                     "duration", "type");
  for (const StreamInfo& stream : info.streams) {
    out += to_text(stream);
  }
  if (info.stereo) {
    const StereoInfo& stereo = *info.stereo;
    out += fmt::format("\nstereo: {} pairs, {}; {} left and {} right images alone\n", stereo.pairs,
                       stereo.synchronised() ? "synchronised" : "not synchronised", stereo.left_alone,
                       stereo.right_alone);
    out += fmt::format("        right stamps are {:+.3f} ms from left ones, up to {:.3f} ms more or less\n",
                       1e3 * stereo.median_difference_s, 1e3 * stereo.spread_s);
    if (brightness) {
      out += fmt::format("        mean grey {:.0f} left, {:.0f} right, of 255\n", brightness->left,
                         brightness->right);
    }
  }
  if (info.calibration) {
    out += "\ncameras: " + to_text("left", info.calibration->cam0) + "         " +
           to_text("right", info.calibration->cam1);
  }
  const std::string topics = format_bag_topics(info.topics);
  out += topics.empty() ? "" : "\ntopics: --topics " + topics + "\n";
  const auto list = [&out](const char* title, const std::vector<std::string>& lines) {
    out += lines.empty() ? "" : fmt::format("\n{}:\n", title);
    for (const std::string& line : lines) {
      out += "  " + line + "\n";
    }
  };
  list("can be done", info.possible);
  list("cannot", info.missing);
  list("notes", info.notes);
  return out;
}

void info(const InfoArguments& arguments) {
  RecordingInfo found = inspect(arguments.recording);
  const auto brightness = look_at_images(found);
  judge_brightness(brightness, found);
  fmt::print("{}", arguments.json ? to_json(found, brightness) : to_text(found, brightness));
}

}  // namespace

void add_info_command(CLI::App& app) {
  auto arguments = std::make_shared<InfoArguments>();
  CLI::App* command = app.add_subcommand("info", "What is in a recording, and what can be done with it");
  command
      ->add_option("RECORDING", arguments->recording,
                   "ROS 1 bag, MCAP, ROS 2 bag, or the folder of a recording")
      ->required()
      ->check(not_empty());
  command->add_flag("--json", arguments->json, "Print JSON instead of text");
  command->footer(
      "\nTopics with their types, rates and gaps, clocks that jump, size and exposure of the images, whether "
      "left\n"
      "and right are synchronised, and the topics that limber would take.\n"
      "Example:\n  limber info flight.bag");
  command->callback([arguments] { info(*arguments); });
}

}  // namespace limber::app
