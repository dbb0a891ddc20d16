// SPDX-License-Identifier: MIT
#include "limber/study/merge_studies.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "datasets/files.hpp"
#include "study/tiny_study.hpp"

namespace limber {
namespace {

namespace fs = std::filesystem;

using testing::content_of;
using ::testing::HasSubstr;
using testing::TemporaryFolder;
using testing::tiny_plan;
using testing::two_cases;

fs::path make_shard(const fs::path& folder, const StudyPlan& plan, Shard shard) {
  StudyOptions options;
  options.shard = shard;
  const fs::path path = folder / ("part" + std::to_string(shard.index));
  run_study(plan, path, options);
  return path;
}

std::string refusal_of_parts(const std::vector<fs::path>& parts, const fs::path& out) {
  try {
    merge_studies(parts, out);
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  ADD_FAILURE() << "no error";
  return "";
}

TEST(MergeStudies, GivesWhatOneCallWouldHaveGivenInAnyOrder) {
  const TemporaryFolder folder;
  const fs::path whole = folder.path() / "whole", merged = folder.path() / "merged";
  run_study(two_cases(5), whole);
  const fs::path a = make_shard(folder.path(), two_cases(5), {1, 3});
  const fs::path b = make_shard(folder.path(), two_cases(5), {2, 3});
  const fs::path c = make_shard(folder.path(), two_cases(5), {3, 3});
  merge_studies({c, a, b}, merged);
  EXPECT_EQ(content_of(merged), content_of(whole));
  EXPECT_EQ(testing::rows_of(merged, "SELECT shard FROM starts ORDER BY shard"),
            (std::vector<std::string>{"1/3", "2/3", "3/3"}));
}

TEST(MergeStudies, LeavesAStudyThatCanBeGoneOnWith) {
  const TemporaryFolder folder;
  const fs::path whole = folder.path() / "whole", merged = folder.path() / "merged";
  run_study(two_cases(5), whole);
  merge_studies({make_shard(folder.path(), two_cases(5), {1, 2})}, merged);
  EXPECT_NE(content_of(merged), content_of(whole));
  run_study(two_cases(5), merged);
  EXPECT_EQ(content_of(merged), content_of(whole));
}

TEST(MergeStudies, RefusesPartsThatDoNotBelongTogetherAndLeavesNothing) {
  const TemporaryFolder folder;
  const fs::path merged = folder.path() / "merged";
  const fs::path part = make_shard(folder.path(), tiny_plan(4), {1, 2});
  EXPECT_THAT(refusal_of_parts({part, part}, merged),
              HasSubstr("holds run 0 of 'tiny', and so does a part before it"));

  StudyPlan other = tiny_plan(4);
  other.seed = 9;
  EXPECT_THAT(refusal_of_parts({part, make_shard(folder.path(), other, {2, 2})}, merged),
              HasSubstr("was made with seed 9, the parts before it with 1"));
  fs::remove(folder.path() / "part2");
  other = tiny_plan(4);
  other.cases[0].scenario.duration = 1.1;
  EXPECT_THAT(refusal_of_parts({part, make_shard(folder.path(), other, {2, 2})}, merged),
              HasSubstr("with other settings than the parts before it:\n  stored: duration: 1"));
  EXPECT_THAT(refusal_of_parts({part, folder.path() / "nowhere"}, merged), HasSubstr("no such file"));
  EXPECT_EQ(testing::files_in(folder.path()), (std::vector<std::string>{"part1", "part2"}));
}

TEST(MergeStudies, DoesNotOverwrite) {
  const TemporaryFolder folder;
  const fs::path part = make_shard(folder.path(), tiny_plan(2), {1, 1});
  const fs::path mine = testing::write_text(folder.path() / "mine", "mine");
  EXPECT_THAT(refusal_of_parts({part}, mine), HasSubstr("expected a name that is not taken"));
  EXPECT_EQ(testing::read_text(mine), "mine");
  EXPECT_THAT(refusal_of_parts({part}, folder.path() / "nowhere" / "out"),
              HasSubstr("expected a place where a database can be made"));
}

}  // namespace
}  // namespace limber
