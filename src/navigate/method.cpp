// SPDX-License-Identifier: MIT
#include "limber/navigate/method.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <optional>
#include <stdexcept>
#include <string_view>
#include <utility>
#include <vector>

#include "limber/core/nearest_word.hpp"
#include "limber/core/split.hpp"

namespace limber {

using Eigen::MatrixXd;
using Eigen::Vector3d;

namespace {

using Kind = ConstraintSet::Kind;

constexpr std::array<std::pair<std::string_view, Kind>, 4> kWords = {
    {{"full", Kind::kFull},
     {"rotation", Kind::kRotation},
     {"rotation+direction", Kind::kRotationDirection},
     {"none", Kind::kListed}}};

[[noreturn]] void unknown_set(const std::string& text, std::string_view item) {
  std::vector<std::string> known;
  for (const auto& word : kWords) {
    known.emplace_back(word.first);
  }
  known.insert(known.end(), parameter_words().begin(), parameter_words().end());
  throw std::invalid_argument("unknown constraint set '" + text + "'" + did_you_mean(item, known) +
                              ", expected full, none, rotation, rotation+direction or a list of "
                              "ax,ay,az,tx,ty,tz; more parameters may follow, such as dt1 or intrinsics1");
}

}  // namespace

std::string to_string(Method method) {
  switch (method) {
    case Method::kEkf:
      return "ekf";
    case Method::kEkfFull:
      return "ekf-full";
    case Method::kLcekf:
      return "lcekf";
    case Method::kSoft:
      return "soft";
    case Method::kConsider:
      return "consider";
    case Method::kAdaptive:
      return "adaptive";
    case Method::kMonoLeft:
      return "mono-left";
    case Method::kOracle:
      break;
  }
  return "oracle";
}

Method method_from_string(const std::string& name) {
  std::string known;
  std::vector<std::string> names;
  for (const Method method : kAllMethods) {
    names.push_back(to_string(method));
    if (names.back() == in_lower_case(name)) {
      return method;
    }
    known += (known.empty() ? "" : ", ") + names.back();
  }
  throw std::invalid_argument("unknown method '" + name + "'" + did_you_mean(name, names) +
                              ", expected one of " + known);
}

ConstraintSet default_constraints(MotionModel motion) {
  return {has_scale(motion) ? Kind::kFull : Kind::kRotationDirection, {}};
}

ConstraintSet constraint_set_from_string(const std::string& text) {
  const std::vector<std::string_view> items = split(text, ',');
  const std::string first = in_lower_case(std::string(items.front()));
  ConstraintSet set{Kind::kListed, {}};
  const auto* word =
      std::find_if(kWords.begin(), kWords.end(), [&](const auto& known) { return known.first == first; });
  const bool has_word = word != kWords.end();
  if (has_word) {
    set.kind = word->second;
  }
  for (std::size_t k = has_word ? 1 : 0; k < items.size(); ++k) {
    const std::optional<ParameterSet> named = parameters_named(items[k]);
    if (!named) {
      unknown_set(text, items[k]);
    }
    set.listed |= *named;
  }
  if (has_word && set.listed != set.more()) {  // the word has said it for theta
    unknown_set(text, "");
  }
  return set;
}

std::string to_string(const ConstraintSet& set) {
  std::string text;
  const auto append = [&](std::string_view name) { text.append(text.empty() ? "" : ",").append(name); };
  if (set.kind != Kind::kListed || set.listed.none()) {
    append(std::find_if(kWords.begin(), kWords.end(), [&](const auto& word) {
             return word.second == set.kind;
           })->first);
  }
  const ParameterSet listed = set.kind == Kind::kListed ? set.listed : set.more();
  for (std::size_t k = 0; k < listed.size(); ++k) {
    if (listed[k]) {
      append(kParameterNames[k]);
    }
  }
  return text;
}

Eigen::Matrix<double, 6, 6> without_length(const Eigen::Matrix<double, 6, 6>& covariance,
                                           const RigParameters& theta) {
  const Vector3d along = theta.tail<3>().normalized();
  Eigen::Matrix<double, 6, 6> across = Eigen::Matrix<double, 6, 6>::Identity();
  across.bottomRightCorner<3, 3>() -= along * along.transpose();
  return across * covariance * across.transpose();
}

MatrixXd constraint_directions(const ConstraintSet& set, const RigParameters& theta) {
  const RigParameters scale = plausible_error(theta.tail<3>().norm());
  switch (set.kind) {
    case Kind::kFull:
      return scale.asDiagonal();
    case Kind::kRotation:
      return MatrixXd(scale.asDiagonal()).leftCols<3>();
    case Kind::kRotationDirection: {
      const Vector3d along = theta.tail<3>().normalized();
      MatrixXd C = MatrixXd::Zero(6, 5);
      C.topLeftCorner<3, 3>() = scale.head<3>().asDiagonal();
      C.block<3, 1>(3, 3) = scale(3) * along.unitOrthogonal();
      C.block<3, 1>(3, 4) = scale(3) * along.cross(along.unitOrthogonal());
      return C;
    }
    case Kind::kListed:
      break;
  }
  MatrixXd C(6, 0);
  for (Eigen::Index k = 0; k < 6; ++k) {
    if (set.listed[static_cast<std::size_t>(k)]) {
      C.conservativeResize(6, C.cols() + 1);
      C.col(C.cols() - 1) = scale(k) * RigParameters::Unit(k);
    }
  }
  return C;
}

}  // namespace limber
