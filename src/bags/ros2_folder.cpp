// SPDX-License-Identifier: MIT
#include "ros2_folder.hpp"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>

#include "io/numbers.hpp"
#include "io/text_file.hpp"
#include "io/yaml_text.hpp"
#include "limber/core/errors.hpp"
#include "openers.hpp"

namespace limber::detail {
namespace {

namespace fs = std::filesystem;

constexpr const char* kMetadata = "metadata.yaml";

/// "name_10.db3" comes after "name_9.db3".
bool in_order(const fs::path& a, const fs::path& b) {
  const std::string x = a.stem().string(), y = b.stem().string();
  return x.size() != y.size() ? x.size() < y.size() : x < y;
}

std::vector<fs::path> files_by_name(const fs::path& folder) {
  std::vector<fs::path> out;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    const std::string ending = entry.path().extension().string();
    if ((ending == ".db3" || ending == ".mcap" || ending == ".zstd") && begins_like_bag(entry.path())) {
      out.push_back(entry.path());
    }
  }
  std::sort(out.begin(), out.end(), in_order);
  return out;
}

/// What metadata.yaml says of the bag; null: nothing, or there is none.
YAML::Node metadata_of(const fs::path& folder) {
  std::error_code error;
  if (!fs::is_regular_file(folder / kMetadata, error)) {
    return {};
  }
  const std::string file = (folder / kMetadata).string();
  const YAML::Node root = parse_yaml(load_text(file), file);
  const YAML::Node information = root.IsMap() ? root["rosbag2_bagfile_information"] : YAML::Node();
  return information.IsDefined() ? information : YAML::Node();
}

std::string word(const YAML::Node& node, const char* name) {
  return node.IsMap() && node[name] && node[name].IsScalar() ? node[name].Scalar() : "";
}

void require_readable_compression(const fs::path& folder, const YAML::Node& metadata) {
  const std::string mode = word(metadata, "compression_mode"), format = word(metadata, "compression_format");
  if (!mode.empty() && mode != "NONE" && format != "zstd") {
    throw DataError((folder / kMetadata).string(), 0, "compression_format zstd, or none", excerpt(format));
  }
}

std::vector<std::string> listed_files(const YAML::Node& metadata) {
  std::vector<std::string> out;
  if (metadata.IsMap() && metadata["relative_file_paths"] && metadata["relative_file_paths"].IsSequence()) {
    for (const YAML::Node& name : metadata["relative_file_paths"]) {
      out.push_back(name.IsScalar() ? name.Scalar() : "");
    }
  }
  return out;
}

/// Until rosbag2's version 3 names began with that of the folder, which may have another one by now.
fs::path listed_path(const fs::path& folder, const std::string& name) {
  const fs::path relative = name;
  const bool leaves = std::find(relative.begin(), relative.end(), "..") != relative.end();
  if (relative.empty() || relative.is_absolute() || leaves) {
    throw DataError((folder / kMetadata).string(), 0, "in relative_file_paths names within the folder",
                    excerpt(name));
  }
  return fs::exists(folder / relative) ? folder / relative : folder / relative.filename();
}

}  // namespace

bool is_ros2_folder(const fs::path& folder) {
  if (!files_by_name(folder).empty()) {
    return true;
  }
  try {
    return !listed_files(metadata_of(folder)).empty();
  } catch (const DataError&) {  // any file of this name
    return false;
  }
}

Ros2Folder ros2_folder(const fs::path& folder) {
  Ros2Folder out;
  const std::vector<fs::path> all = files_by_name(folder);
  YAML::Node metadata;
  try {
    metadata = metadata_of(folder);
  } catch (const DataError& error) {
    out.remarks.emplace_back(error.what());
  }
  require_readable_compression(folder, metadata);
  for (const std::string& name : listed_files(metadata)) {
    const fs::path path = listed_path(folder, name);
    if (fs::exists(path)) {
      out.files.push_back(path);
    } else {
      out.missing.push_back(fmt::format("{} is listed in {} and missing", path.string(), kMetadata));
    }
  }
  if (out.files.empty() && out.missing.empty()) {
    out.files = all;
    if (all.size() > 1) {
      out.remarks.push_back(
          fmt::format("no {} lists the files of this bag: {} of them, {} to {}, are read as one", kMetadata,
                      all.size(), all.front().filename().string(), all.back().filename().string()));
    }
    return out;
  }
  for (const fs::path& path : all) {
    if (std::find(out.files.begin(), out.files.end(), path) == out.files.end()) {
      out.remarks.push_back(fmt::format("{} is not listed in {} and left out", path.string(), kMetadata));
    }
  }
  return out;
}

}  // namespace limber::detail
