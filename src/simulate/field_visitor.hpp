// SPDX-License-Identifier: MIT
#pragma once

#include <yaml-cpp/yaml.h>

#include <Eigen/Core>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "limber/sensors/calibration.hpp"
#include "limber/simulate/decalibration.hpp"

/// Reading and writing a structure through one description of its fields: a function visits them with a
/// reader or a writer, so that what is written can be read, and both make the same checks.
namespace limber::detail {

/// Allowed values of a number, in the unit of the file.
struct Range {
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
  bool min_excluded = false;

  [[nodiscard]] bool contains(double value) const;
  [[nodiscard]] std::string in_words() const;  ///< "a number in (0, 10]"
};

inline const Range kPositive{.min = 0.0, .max = 1e6, .min_excluded = true};
inline const Range kNotNegative{.min = 0.0, .max = 1e6};
inline const Range kAnyNumber{.min = -1e6, .max = 1e6};

/// How a number stands in the file: value / scale, in `name`.
struct Unit {
  std::string name;
  double scale = 1.0;
};

inline const Unit kDegrees{"deg", kDegree};
inline const Unit kMetres{"m", 1.0};
inline const Unit kSeconds{"s", 1.0};
inline const Unit kNoUnit{"", 1.0};

/// @brief Visits the fields of one mapping. A reader lets absent keys keep their value and refuses what does
/// not fit (DataError); a writer writes every key and refuses what a reader would (std::invalid_argument).
class FieldVisitor {
 public:
  using Visit = std::function<void(FieldVisitor&)>;
  using VisitEntry = std::function<void(std::size_t, FieldVisitor&)>;

  virtual ~FieldVisitor() = default;

  virtual void number(const std::string& key, double& value, const Range& range, const Unit& unit) = 0;
  virtual void boolean(const std::string& key, bool& value) = 0;
  virtual void text(const std::string& key, std::string& value) = 0;
  /// A list of exactly value.size() numbers.
  virtual void numbers(const std::string& key, Eigen::Ref<Eigen::VectorXd> value, const Range& range,
                       const Unit& unit) = 0;
  /// Three angles in degrees and three lengths [m], which may be read as percent of `baseline` ('5%').
  virtual void rig_parameters(const std::string& key, RigParameters& value, double baseline,
                              const Range& range) = 0;
  /// One of `names`. @return its index
  virtual std::size_t choice(const std::string& key, std::size_t index,
                             const std::vector<std::string>& names) = 0;
  virtual void mapping(const std::string& key, const Visit& visit) = 0;
  /// A list of mappings of `size` entries; a reader first calls `resize` with the number it finds.
  virtual void list(const std::string& key, std::size_t size, const std::function<void(std::size_t)>& resize,
                    const VisitEntry& visit) = 0;

  /// For what is optional: whether the file has the key (reader), or `present` (writer).
  [[nodiscard]] virtual bool has(const std::string& key, bool present) = 0;
  /// For what may be a word instead of a mapping: whether it is one in the file; false for a writer.
  [[nodiscard]] virtual bool is_word(const std::string& key) = 0;
  /// For what has no default: a reader fails if the key is absent.
  virtual void require(const std::string& key) = 0;
  /// What messages call a key: that of a short form, of which the mapping was made. Nothing to a writer.
  virtual void call(const std::string& key, const std::string& words) = 0;
  /// Fails at `key` unless `condition` holds.
  virtual void check(const std::string& key, bool condition, const std::string& expected,
                     const std::string& found) = 0;

  void integer(const std::string& key, int& value, const Range& range, const Unit& unit);
  void path(const std::string& key, std::filesystem::path& value);
};

/// @brief Visits all fields of the mapping `text`; strict: unknown and repeated keys are refused too.
/// @param file for messages
void read_fields(const std::string& text, const std::string& file, const FieldVisitor::Visit& visit);

[[nodiscard]] std::string write_fields(const FieldVisitor::Visit& visit);

}  // namespace limber::detail
