// SPDX-License-Identifier: MIT
#include "io/yaml_text.hpp"

#include <yaml-cpp/eventhandler.h>

#include <cstddef>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "io/yaml_words.hpp"
#include "limber/core/errors.hpp"

namespace limber::detail {
namespace {

/// Follows a parser's events to see that no key of a mapping stands twice: YAML forbids it, yaml-cpp takes
/// one.
class UniqueKeys final : public YAML::EventHandler {
 public:
  explicit UniqueKeys(const std::string& file) : file_(file) {}

  void OnDocumentStart(const YAML::Mark&) override {}
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark&, YAML::anchor_t) override { next(); }
  void OnAlias(const YAML::Mark&, YAML::anchor_t) override { next(); }
  void OnScalar(const YAML::Mark& mark, const std::string&, YAML::anchor_t,
                const std::string& value) override {
    if (!open_.empty() && open_.back().at_key && value != kMerge) {
      const auto [before, is_new] = open_.back().lines.try_emplace(value, line_of(mark));
      if (!is_new) {
        throw DataError(file_, line_of(mark), "each key once",
                        fmt::format("{}, which stands in line {}, too", excerpt(value), before->second));
      }
    }
    next();
  }
  void OnSequenceStart(const YAML::Mark&, const std::string&, YAML::anchor_t,
                       YAML::EmitterStyle::value) override {
    open_.push_back({});
  }
  void OnSequenceEnd() override { close(); }
  void OnMapStart(const YAML::Mark&, const std::string&, YAML::anchor_t, YAML::EmitterStyle::value) override {
    open_.push_back({.is_map = true, .at_key = true});
  }
  void OnMapEnd() override { close(); }

 private:
  static constexpr const char* kMerge = "<<";  // may stand more than once

  struct Collection {
    bool is_map = false, at_key = false;  // the latter: what comes next is one
    std::map<std::string, std::size_t> lines{};
  };

  void next() {
    if (!open_.empty() && open_.back().is_map) {
      open_.back().at_key = !open_.back().at_key;
    }
  }
  void close() {
    open_.pop_back();
    next();
  }

  const std::string& file_;
  std::vector<Collection> open_;
};

/// Whether a second document begins after the first. Not more: yaml-cpp makes endless empty documents of a
/// lone ','.
/// @throws DataError if a key stands twice
bool has_second_document(const std::string& text, const std::string& file) {
  std::istringstream stream(text);
  YAML::Parser parser(stream);
  UniqueKeys keys(file);
  return parser.HandleNextDocument(keys) && parser.HandleNextDocument(keys);
}

}  // namespace

YAML::Node parse_yaml(const std::string& text, const std::string& file) {
  try {
    if (has_second_document(text, file)) {
      throw DataError(file, 0, "one YAML document", "more than one, or a ',' that belongs to none");
    }
    return YAML::Load(text);
  } catch (const YAML::Exception& e) {
    throw DataError(file, line_of(e.mark), "valid YAML", e.msg);
  }
}

}  // namespace limber::detail
