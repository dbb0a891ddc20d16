// SPDX-License-Identifier: MIT
#include "field_visitor.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>
#include <string_view>

#include "io/numbers.hpp"
#include "io/yaml_text.hpp"
#include "io/yaml_words.hpp"
#include "limber/core/errors.hpp"
#include "limber/simulate/decalibration.hpp"

namespace limber::detail {
namespace {

std::string joined_path(const std::string& parent, const std::string& key) {
  return parent.empty() ? key : parent + "." + key;
}

/// The shortest decimal that a reader turns into exactly `value` when it multiplies by `scale`.
std::string decimal(double value, double scale) {
  for (int digits = 1; digits <= 17; ++digits) {
    const double rounded = *parse_number(fmt::format("{:.{}g}", value / scale, digits));
    if (rounded * scale == value) {
      return fmt::format("{}", rounded);
    }
  }
  for (const double neighbour : {-HUGE_VAL, HUGE_VAL}) {
    const double x = std::nextafter(value / scale, neighbour);
    if (x * scale == value) {
      return fmt::format("{}", x);
    }
  }
  return fmt::format("{}", value / scale);
}

class Reader final : public FieldVisitor {
 public:
  Reader(std::string file, const YAML::Node& mapping, std::string key_path)
      : file_(std::move(file)), mapping_(mapping), key_path_(std::move(key_path)) {
    refuse_keys_that_are_no_names();
  }

  void number(const std::string& key, double& value, const Range& range, const Unit& unit) override {
    if (const YAML::Node node = find(key)) {
      value = number_of(key, node, range, unit.name) * unit.scale;
    }
  }

  void boolean(const std::string& key, bool& value) override {
    if (const YAML::Node node = find(key)) {
      const std::string found = node.IsScalar() ? node.Scalar() : "";
      if (found != "true" && found != "false") {
        fail(node, name_of(key) + " as true or false", in_words(node));
      }
      value = found == "true";
    }
  }

  void text(const std::string& key, std::string& value) override {
    if (const YAML::Node node = find(key)) {
      if (!node.IsScalar()) {
        fail(node, name_of(key) + " as text", in_words(node));
      }
      value = node.Scalar();
    }
  }

  void numbers(const std::string& key, Eigen::Ref<Eigen::VectorXd> value, const Range& range,
               const Unit& unit) override {
    if (const YAML::Node node = list_of(key, value.size())) {
      for (Eigen::Index i = 0; i < value.size(); ++i) {
        value[i] = number_of(key, node[static_cast<std::size_t>(i)], range, unit.name) * unit.scale;
      }
    }
  }

  void rig_parameters(const std::string& key, RigParameters& value, double baseline,
                      const Range& range) override {
    if (const YAML::Node node = list_of(key, value.size())) {
      for (Eigen::Index i = 0; i < 3; ++i) {
        value[i] = number_of(key, node[static_cast<std::size_t>(i)], range, "deg") * kDegree;
        value[i + 3] = length_of(key, node[static_cast<std::size_t>(i + 3)], baseline, range);
      }
    }
  }

  std::size_t choice(const std::string& key, std::size_t index,
                     const std::vector<std::string>& names) override {
    const YAML::Node node = find(key);
    if (!node) {
      return index;
    }
    const auto found = std::find(names.begin(), names.end(), node.IsScalar() ? node.Scalar() : "");
    if (found == names.end()) {
      fail(node, fmt::format("{} as one of {}", name_of(key), fmt::join(names, ", ")), in_words(node));
    }
    return static_cast<std::size_t>(found - names.begin());
  }

  void mapping(const std::string& key, const Visit& visit) override {
    if (const YAML::Node node = find(key)) {
      visit_child(node, name_of(key), visit);
    }
  }

  void list(const std::string& key, std::size_t, const std::function<void(std::size_t)>& resize,
            const VisitEntry& visit) override {
    const YAML::Node node = find(key);
    if (!node) {
      return;
    }
    if (!node.IsSequence()) {
      fail(node, name_of(key) + " as a list of mappings", in_words(node));
    }
    resize(node.size());
    for (std::size_t i = 0; i < node.size(); ++i) {
      visit_child(node[i], fmt::format("{}[{}]", name_of(key), i),
                  [&](FieldVisitor& child) { visit(i, child); });
    }
  }

  [[nodiscard]] bool has(const std::string& key, bool) override { return static_cast<bool>(find(key)); }

  [[nodiscard]] bool is_word(const std::string& key) override {
    const YAML::Node node = find(key);
    return node && node.IsScalar();
  }

  void require(const std::string& key) override {
    if (!find(key)) {
      fail(mapping_, "the key " + name_of(key), "no such key");
    }
  }

  void check(const std::string& key, bool condition, const std::string& expected,
             const std::string& found) override {
    if (!condition) {
      const YAML::Node node = find(key);
      fail(node ? node : mapping_, name_of(key) + " " + expected, found);
    }
  }

  void call(const std::string& key, const std::string& words) override { called_[key] = words; }

  /// Refuses the keys that nobody asked for.
  void finish() const {
    for (const auto& entry : mapping_) {
      const std::string key = entry.first.Scalar();
      if (std::find(visited_.begin(), visited_.end(), key) == visited_.end()) {
        fail(entry.first,
             fmt::format("one of the keys {}{}", fmt::join(known_keys(), ", "),
                         key_path_.empty() ? "" : " in " + key_path_),
             "the unknown key " + excerpt(key));
      }
    }
  }

 private:
  void visit_child(const YAML::Node& node, const std::string& name, const Visit& visit) const {
    if (!node.IsMap()) {
      fail(node, name + " as a mapping (key: value)", in_words(node));
    }
    Reader child(file_, node, name);
    visit(child);
    child.finish();
  }

  void refuse_keys_that_are_no_names() const {
    for (const auto& entry : mapping_) {
      if (!entry.first.IsScalar()) {
        fail(entry.first, "a name as key", in_words(entry.first));
      }
    }
  }

  [[nodiscard]] std::vector<std::string> known_keys() const {
    std::vector<std::string> out = visited_;
    for (std::string& key : out) {
      if (const auto words = called_.find(key); words != called_.end()) {
        key = words->second;
      }
    }
    return out;
  }

  YAML::Node find(const std::string& key) {
    if (std::find(visited_.begin(), visited_.end(), key) == visited_.end()) {
      visited_.push_back(key);
    }
    for (const auto& entry : mapping_) {
      if (entry.first.Scalar() == key) {
        line_of_key_ = line_of(entry.first.Mark());
        return entry.second;
      }
    }
    return YAML::Node(YAML::NodeType::Undefined);
  }

  YAML::Node list_of(const std::string& key, Eigen::Index size) {
    const YAML::Node node = find(key);
    if (node && (!node.IsSequence() || static_cast<Eigen::Index>(node.size()) != size)) {
      fail(node, fmt::format("{} as a list of {} numbers", name_of(key), size), in_words(node));
    }
    return node;
  }

  [[nodiscard]] double number_of(const std::string& key, const YAML::Node& node, const Range& range,
                                 const std::string& unit) const {
    const auto value = node.IsScalar() ? parse_number(node.Scalar()) : std::nullopt;
    if (!value || !range.contains(*value)) {
      fail(node, fmt::format("{} as {}{}{}", name_of(key), range.in_words(), unit.empty() ? "" : " ", unit),
           in_words(node));
    }
    return *value;
  }

  [[nodiscard]] double length_of(const std::string& key, const YAML::Node& node, double baseline,
                                 const Range& range) const {
    const std::string text = node.IsScalar() ? node.Scalar() : "";
    if (!text.ends_with('%')) {
      return number_of(key, node, range, "m, or a percentage of the baseline such as 5%");
    }
    const auto percent = parse_number(std::string_view(text).substr(0, text.size() - 1));
    if (!percent || !range.contains(*percent * 0.01 * baseline)) {
      fail(node,
           fmt::format("{} as {} m, or a percentage of the baseline such as 5%", name_of(key),
                       range.in_words()),
           in_words(node));
    }
    return *percent * 0.01 * baseline;
  }

  [[nodiscard]] std::string name_of(const std::string& key) const { return joined_path(key_path_, key); }

  [[noreturn]] void fail(const YAML::Node& node, const std::string& expected,
                         const std::string& found) const {
    // yaml-cpp finds an absent value on the line below.
    throw DataError(file_, node.IsNull() ? line_of_key_ : line_of(node.Mark()), expected, found);
  }

  std::string file_;
  YAML::Node mapping_;
  std::string key_path_;
  std::vector<std::string> visited_;
  std::map<std::string, std::string> called_;  // by key
  std::size_t line_of_key_ = 0;                // the key that find() found last
};

class Writer final : public FieldVisitor {
 public:
  Writer(YAML::Emitter& out, std::string key_path) : out_(out), key_path_(std::move(key_path)) {}

  void number(const std::string& key, double& value, const Range& range, const Unit& unit) override {
    out_ << YAML::Key << key << YAML::Value << checked(key, value, range, unit);
    comment(unit.name);
  }

  void boolean(const std::string& key, bool& value) override {
    out_ << YAML::Key << key << YAML::Value << (value ? "true" : "false");
  }

  void text(const std::string& key, std::string& value) override {
    out_ << YAML::Key << key << YAML::Value << YAML::DoubleQuoted << value;
  }

  void numbers(const std::string& key, Eigen::Ref<Eigen::VectorXd> value, const Range& range,
               const Unit& unit) override {
    out_ << YAML::Key << key << YAML::Value << YAML::Flow << YAML::BeginSeq;
    for (const double v : value) {
      out_ << checked(key, v, range, unit);
    }
    out_ << YAML::EndSeq;
    comment(unit.name);
  }

  void rig_parameters(const std::string& key, RigParameters& value, double, const Range& range) override {
    out_ << YAML::Key << key << YAML::Value << YAML::Flow << YAML::BeginSeq;
    for (Eigen::Index i = 0; i < value.size(); ++i) {
      out_ << checked(key, value[i], range, i < 3 ? kDegrees : kMetres);
    }
    out_ << YAML::EndSeq;
    comment("deg, deg, deg, m, m, m");
  }

  std::size_t choice(const std::string& key, std::size_t index,
                     const std::vector<std::string>& names) override {
    out_ << YAML::Key << key << YAML::Value << names.at(index);
    return index;
  }

  void mapping(const std::string& key, const Visit& visit) override {
    out_ << YAML::Key << key << YAML::Value << YAML::BeginMap;
    Writer child(out_, joined_path(key_path_, key));
    visit(child);
    out_ << YAML::EndMap;
  }

  void list(const std::string& key, std::size_t size, const std::function<void(std::size_t)>&,
            const VisitEntry& visit) override {
    out_ << YAML::Key << key << YAML::Value << YAML::BeginSeq;
    for (std::size_t i = 0; i < size; ++i) {
      out_ << YAML::BeginMap;
      Writer child(out_, fmt::format("{}[{}]", joined_path(key_path_, key), i));
      visit(i, child);
      out_ << YAML::EndMap;
    }
    out_ << YAML::EndSeq;
  }

  [[nodiscard]] bool has(const std::string&, bool present) override { return present; }
  [[nodiscard]] bool is_word(const std::string&) override { return false; }
  void require(const std::string&) override {}
  void call(const std::string&, const std::string&) override {}

  void check(const std::string& key, bool condition, const std::string& expected,
             const std::string& found) override {
    if (!condition) {
      throw std::invalid_argument(
          fmt::format("scenario: expected {} {}, got {}", joined_path(key_path_, key), expected, found));
    }
  }

 private:
  std::string checked(const std::string& key, double value, const Range& range, const Unit& unit) {
    const std::string text = decimal(value, unit.scale);
    check(key, range.contains(*parse_number(text)), fmt::format("as {} {}", range.in_words(), unit.name),
          text);
    return text;
  }

  void comment(const std::string& unit) {
    if (!unit.empty()) {
      out_ << YAML::Comment(unit);
    }
  }

  YAML::Emitter& out_;
  std::string key_path_;
};

}  // namespace

bool Range::contains(double value) const {
  return std::isfinite(value) && (min_excluded ? value > min : value >= min) && value <= max;
}

std::string Range::in_words() const {
  if (std::isinf(min) && std::isinf(max)) {
    return "a finite number";
  }
  if (std::isinf(max)) {
    return fmt::format("a number {} {}", min_excluded ? "above" : "of at least", min);
  }
  return fmt::format("a number in {}{}, {}]", min_excluded ? "(" : "[", min, max);
}

void FieldVisitor::integer(const std::string& key, int& value, const Range& range, const Unit& unit) {
  double number_value = value;
  number(key, number_value, range, unit);
  check(key, number_value == std::floor(number_value), "as a whole number", fmt::format("{}", number_value));
  value = static_cast<int>(number_value);
}

void FieldVisitor::path(const std::string& key, std::filesystem::path& value) {
  std::string text_value = value.string();
  text(key, text_value);
  value = text_value;
}

void read_fields(const std::string& text, const std::string& file, const FieldVisitor::Visit& visit) {
  const YAML::Node root = parse_yaml(text, file);
  if (!root.IsMap()) {
    throw DataError(file, line_of(root.Mark()), "a YAML mapping (key: value)",
                    root.IsDefined() && !root.IsNull() ? in_words(root) : "an empty file");
  }
  Reader reader(file, root, "");
  visit(reader);
  reader.finish();
}

std::string write_fields(const FieldVisitor::Visit& visit) {
  YAML::Emitter out;
  Writer writer(out, "");
  out << YAML::BeginMap;
  visit(writer);
  out << YAML::EndMap;
  return std::string(out.c_str()) + "\n";
}

}  // namespace limber::detail
