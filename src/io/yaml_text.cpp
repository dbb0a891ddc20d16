// SPDX-License-Identifier: MIT
#include "io/yaml_text.hpp"

#include <yaml-cpp/eventhandler.h>

#include <sstream>

#include "io/yaml_words.hpp"
#include "limber/core/errors.hpp"

namespace limber::detail {
namespace {

/// Takes a parser's events and keeps nothing.
class Ignore final : public YAML::EventHandler {
 public:
  void OnDocumentStart(const YAML::Mark&) override {}
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark&, YAML::anchor_t) override {}
  void OnAlias(const YAML::Mark&, YAML::anchor_t) override {}
  void OnScalar(const YAML::Mark&, const std::string&, YAML::anchor_t, const std::string&) override {}
  void OnSequenceStart(const YAML::Mark&, const std::string&, YAML::anchor_t,
                       YAML::EmitterStyle::value) override {}
  void OnSequenceEnd() override {}
  void OnMapStart(const YAML::Mark&, const std::string&, YAML::anchor_t, YAML::EmitterStyle::value) override {
  }
  void OnMapEnd() override {}
};

/// Whether a second document begins after the first. Not more: yaml-cpp makes endless empty documents of a
/// lone ','.
bool has_second_document(const std::string& text) {
  std::istringstream stream(text);
  YAML::Parser parser(stream);
  Ignore ignore;
  return parser.HandleNextDocument(ignore) && parser.HandleNextDocument(ignore);
}

}  // namespace

YAML::Node parse_yaml(const std::string& text, const std::string& file) {
  try {
    if (has_second_document(text)) {
      throw DataError(file, 0, "one YAML document", "more than one, or a ',' that belongs to none");
    }
    return YAML::Load(text);
  } catch (const YAML::Exception& e) {
    throw DataError(file, line_of(e.mark), "valid YAML", e.msg);
  }
}

}  // namespace limber::detail
