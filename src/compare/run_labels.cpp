// SPDX-License-Identifier: MIT
#include "run_labels.hpp"

#include <algorithm>
#include <set>
#include <stdexcept>

namespace limber::detail {
namespace {

namespace fs = std::filesystem;

/// The names along a path.
std::vector<fs::path> parts_of(const fs::path& path) {
  const fs::path whole = (fs::weakly_canonical(path) / "").parent_path();
  return {whole.begin(), whole.end()};
}

void require_different(const std::vector<RunFolder>& runs) {
  std::set<fs::path> seen;
  for (const RunFolder& run : runs) {
    if (!seen.insert((fs::weakly_canonical(run.path) / "").parent_path()).second) {
      throw std::invalid_argument(run.path.string() + " is given twice: expected different runs");
    }
  }
}

std::size_t common_parts(const std::vector<std::vector<fs::path>>& paths) {
  std::size_t common = paths.front().size() - 1;
  for (const auto& parts : paths) {
    const auto end =
        std::mismatch(parts.begin(), parts.end() - 1, paths.front().begin(), paths.front().end());
    common = std::min(common, static_cast<std::size_t>(end.first - parts.begin()));
  }
  return common;
}

}  // namespace

std::vector<std::string> run_labels(const std::vector<RunFolder>& runs) {
  require_different(runs);
  std::vector<std::string> labels;
  for (const RunFolder& run : runs) {
    labels.push_back(run.method);
  }
  if (std::set<std::string>(labels.begin(), labels.end()).size() == labels.size()) {
    return labels;
  }
  std::vector<std::vector<fs::path>> paths;
  for (const RunFolder& run : runs) {
    paths.push_back(parts_of(run.path));
  }
  const std::size_t common = common_parts(paths);
  for (std::size_t k = 0; k < runs.size(); ++k) {
    fs::path rest;
    for (std::size_t part = common; part < paths[k].size(); ++part) {
      rest /= paths[k][part];
    }
    labels[k] = rest.string();
  }
  return labels;
}

}  // namespace limber::detail
