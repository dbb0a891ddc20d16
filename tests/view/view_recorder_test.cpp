// SPDX-License-Identifier: MIT
#include "limber/view/view_recorder.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "datasets/files.hpp"
#include "limber/core/errors.hpp"
#include "view/small_view.hpp"

namespace limber {
namespace {

using Json = nlohmann::json;
using testing::read_text;
using testing::small_frame;
using testing::small_run;

/// What stands in the page.
Json data_in(const std::string& page) {
  const std::string begin = "id=\"view-data\">";
  const std::size_t from = page.find(begin) + begin.size();
  return Json::parse(page.substr(from, page.find("</script>", from) - from));
}

TEST(ViewRecorder, WritesAPageWithRunPathAndFrames) {
  const testing::TemporaryFolder folder;
  ViewRun run = small_run();
  run.title = "a </script> <b>title</b>";
  ViewRecorder recorder(run);
  for (std::size_t n = 1; n <= 3; ++n) {
    recorder.note(0.05 * static_cast<double>(n), {1.0, 2.0, 3.0});
    ASSERT_TRUE(recorder.wants(n));
    recorder.add(small_frame(n));
  }
  recorder.write(folder.path() / "page.html", "done \"so far\"");
  const Json data = data_in(read_text(folder.path() / "page.html"));
  EXPECT_EQ(data["run"]["title"], run.title);
  EXPECT_EQ(data["message"], "done \"so far\"");
  ASSERT_EQ(data["frames"].size(), 3u);
  EXPECT_EQ(data["frames"][2]["n"], 3);
  EXPECT_EQ(data["path"].get<std::string>().size(), 64u);  // 3 x 16 bytes
}

TEST(ViewRecorder, KeepsFramesEvenlyAndNoMoreThanItsLimit) {
  ViewRun run = small_run();
  run.frames = 24'000;
  ViewRecorder recorder(run);
  std::vector<std::size_t> kept;
  for (std::size_t n = 1; n <= run.frames; ++n) {
    if (recorder.wants(n)) {
      kept.push_back(n);
      recorder.add(small_frame(n));
    }
  }
  ASSERT_EQ(kept.size(), ViewRecorder::kMostFrames);
  EXPECT_EQ(kept.front(), 100u);
  EXPECT_EQ(kept.back(), 24'000u);
  EXPECT_FALSE(recorder.wants(24'100));
}

TEST(ViewRecorder, SaysWhereItCannotWrite) {
  const ViewRecorder recorder(small_run());
  EXPECT_THROW(recorder.write("/nowhere/page.html", ""), DataError);
}

}  // namespace
}  // namespace limber
