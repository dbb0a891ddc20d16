// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "io/sqlite.hpp"
#include "limber/study/exact_sum.hpp"
#include "limber/study/study_item.hpp"
#include "limber/study/study_plan.hpp"

namespace limber::detail {

/// Who computes, for the record; nothing that results depend on.
struct StartRecord {
  std::string program_version;
  int processes = 1, threads = 1;
  std::string shard = "1/1";
};

/// Lines that only one of two definitions has.
[[nodiscard]] std::string differing_lines(const std::string& stored, const std::string& asked);

/// @brief The database of a study as its writer sees it: begun or taken up again, and filled item by item,
/// each in one transaction.
class StudyStore {
 public:
  /// @brief Makes the database, or takes up one that fits the plan. Cases may be new to it, and have more
  /// runs than it knew of.
  /// @throws DataError if the file cannot be used or written
  /// @throws std::runtime_error if it was begun with another seed, scenario or methods; the message says what
  /// differs
  StudyStore(const std::filesystem::path& path, const StudyPlan& plan, const StartRecord& start);

  [[nodiscard]] bool is_finished(std::size_t study_case, std::uint64_t run) const;

  /// Adds the results of one item. If another process was faster, the item is left as it is.
  void save(const ItemResult& result);

  /// @throws std::runtime_error if a finished item was computed anew with other numbers: this program must
  /// not go on with what that one began
  void compare(const ItemResult& result) const;

 private:
  void take_up(const StudyPlan& plan, const StartRecord& start);
  void add_case(const StudyCase& study_case, const std::string& definition);
  void take_up_case(std::size_t index, const StudyCase& study_case);
  void load_finished(std::size_t index);
  void save_method(const ItemResult& result, std::size_t method);

  SqliteFile file_;
  std::vector<std::int64_t> ids_;            // of the plan's cases in the database
  std::vector<std::size_t> frames_;          // of a run of each case
  std::vector<std::vector<bool>> finished_;  // by case and run
};

/// Adds to the stored sums of one curve, or begins them. @throws std::invalid_argument if the frames differ
/// in number
void add_to_curve(const SqliteFile& file, std::int64_t case_id, std::size_t method, CurveQuantity quantity,
                  const CurveSum& terms);

}  // namespace limber::detail
