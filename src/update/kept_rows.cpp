// SPDX-License-Identifier: MIT
#include "kept_rows.hpp"

#include <cstddef>

namespace limber {

using Eigen::Index;

KeptRows kept_rows(const std::vector<RowGroup>& groups, const std::vector<bool>& kept, Index moved,
                   Index stateless) {
  std::vector<Index> new_row(static_cast<std::size_t>(moved + stateless), -1);
  const auto at = [&](Index row) -> Index& { return new_row[static_cast<std::size_t>(row)]; };
  for (std::size_t g = 0; g < groups.size(); ++g) {
    if (kept[g]) {
      for (Index k = 0; k < groups[g].rows; ++k) {
        at(groups[g].row + k) = 0;
      }
      if (groups[g].fourth >= 0) {
        at(groups[g].fourth) = 0;
      }
    }
  }
  KeptRows out;
  Index next = 0;
  for (Index row = 0; row < moved + stateless; ++row) {
    if (at(row) == 0) {
      at(row) = next++;
      row < moved ? out.moved.push_back(row) : out.stateless.push_back(row - moved);
    }
  }
  for (std::size_t g = 0; g < groups.size(); ++g) {
    if (kept[g]) {
      RowGroup& group = out.groups.emplace_back(groups[g]);
      group.row = at(group.row);
      group.fourth = group.fourth >= 0 ? at(group.fourth) : -1;
    }
  }
  return out;
}

}  // namespace limber
