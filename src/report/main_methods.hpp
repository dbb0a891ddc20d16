// SPDX-License-Identifier: MIT
#pragma once

#include "limber/report/study_results.hpp"

namespace limber::detail {

/// The methods that reports compare first.
enum class MainMethod { kEkf, kEkfFull, kLcekf };

/// The plain form of a method in a case: lcekf with all six parameters constrained, ekf-full with the
/// scenario's walk. nullptr if it is not there.
[[nodiscard]] const StudyMethodResults* find_main_method(const StudyCaseResults& study_case,
                                                         MainMethod method);

}  // namespace limber::detail
