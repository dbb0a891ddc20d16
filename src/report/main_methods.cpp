// SPDX-License-Identifier: MIT
#include "report/main_methods.hpp"

#include <algorithm>

namespace limber::detail {
namespace {

bool is_plain(const Scenario& scenario, const MethodVariant& variant, MainMethod method) {
  switch (method) {
    case MainMethod::kEkf:
      return variant.method == Method::kEkf;
    case MainMethod::kEkfFull:
      return variant.method == Method::kEkfFull && !variant.walk;
    case MainMethod::kLcekf:  // without an IMU the default set leaves the length of the baseline out
      return variant.method == Method::kLcekf &&
             (variant.constraints ? variant.constraints->kind == ConstraintSet::Kind::kFull
                                  : scenario.use_imu);
  }
  return false;
}

}  // namespace

const StudyMethodResults* find_main_method(const StudyCaseResults& study_case, MainMethod method) {
  const auto found = std::find_if(study_case.methods.begin(), study_case.methods.end(),
                                  [&](const StudyMethodResults& candidate) {
                                    return is_plain(study_case.info.scenario, candidate.variant, method);
                                  });
  return found != study_case.methods.end() ? &*found : nullptr;
}

}  // namespace limber::detail
