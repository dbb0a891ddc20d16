// SPDX-License-Identifier: MIT
#pragma once

#include <stdexcept>
#include <string>
#include <variant>

#include "limber/report/document.hpp"

namespace limber::testing {

/// @throws std::out_of_range if there is none
inline const ReportFigure& figure(const ReportDocument& document, const std::string& id) {
  for (const ReportSection& section : document.sections) {
    for (const ReportBlock& block : section.blocks) {
      const auto* found = std::get_if<ReportFigure>(&block);
      if (found != nullptr && found->id == id) {
        return *found;
      }
    }
  }
  throw std::out_of_range("no figure " + id);
}

/// @throws std::out_of_range if there is none
inline const ReportTrace& trace(const ReportFigure& figure, const std::string& name) {
  for (const ReportTrace& trace : figure.traces) {
    if (trace.name == name) {
      return trace;
    }
  }
  throw std::out_of_range("no trace " + name);
}

}  // namespace limber::testing
