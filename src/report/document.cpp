// SPDX-License-Identifier: MIT
#include "limber/report/document.hpp"

#include <stdexcept>

namespace limber {

std::string_view to_string(Verdict verdict) {
  switch (verdict) {
    case Verdict::kAgrees:
      return "agrees";
    case Verdict::kDisagrees:
      return "does not agree";
    case Verdict::kNotMeasured:
      return "not measured";
  }
  throw std::invalid_argument("to_string: no such verdict");
}

}  // namespace limber
