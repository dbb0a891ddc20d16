// SPDX-License-Identifier: MIT
#include "limber/report/write_report.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <regex>

#include "datasets/files.hpp"
#include "report/small_document.hpp"

namespace limber {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::read_text;
using testing::small_document;
using testing::TemporaryFolder;

class WriteReport : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!can_write_reports()) {
      GTEST_SKIP() << why_no_reports();
    }
  }
  std::string written(const ReportDocument& document) {
    write_report(document, folder_.path() / "report.html");
    return read_text(folder_.path() / "report.html");
  }
  TemporaryFolder folder_;
};

/// What stands in the element that holds the data.
std::string data_in(const std::string& page) {
  const std::string open = R"(<script type="application/json" id="report-data">)";
  const std::size_t begin = page.find(open) + open.size();
  return page.substr(begin, page.find("</script>", begin) - begin);
}

TEST_F(WriteReport, PutsTheDocumentIntoThePage) {
  const std::string page = written(small_document());
  EXPECT_EQ(Json::parse(data_in(page)), Json::parse(report_json(small_document())));
  EXPECT_THAT(page, HasSubstr("<title>A title</title>"));
  EXPECT_THAT(page, Not(HasSubstr("<!--limber:")));
  EXPECT_THAT(page, Not(HasSubstr("/*limber:")));
}

TEST_F(WriteReport, LetsNoTextBecomeMarkup) {
  ReportDocument document = small_document();
  document.title = "</title><script>alert(1)</script> & <!-- more";
  const std::string page = written(document);
  EXPECT_THAT(
      page,
      HasSubstr("<title>&lt;/title&gt;&lt;script&gt;alert(1)&lt;/script&gt; &amp; &lt;!-- more</title>"));
  EXPECT_THAT(data_in(page), Not(HasSubstr("<")));
  EXPECT_EQ(Json::parse(data_in(page))["title"], document.title);
}

TEST_F(WriteReport, FetchesNothing) {
  const std::string page = written(small_document());
  // Plotly.js, which the browser test watches, is left out here.
  const std::size_t plotly = page.find("plotly.js (gl3d");
  ASSERT_NE(plotly, std::string::npos);
  const std::string head = page.substr(0, plotly);
  EXPECT_FALSE(std::regex_search(head, std::regex(R"((src|href)="(https?:|//))")));
  EXPECT_THAT(head, HasSubstr("default-src 'none'"));
}

TEST_F(WriteReport, WritesAllOrNothing) {
  const fs::path occupied = folder_.path() / "folder";
  fs::create_directory(occupied);
  const DataError error = testing::data_error_of([&] { write_report(small_document(), occupied); });
  EXPECT_EQ(error.file(), occupied.string());
  ReportDocument broken = small_document();
  broken.sections[1].id = broken.sections[0].id;
  EXPECT_THROW(write_report(broken, folder_.path() / "report.html"), std::invalid_argument);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_.path()), fs::directory_iterator{}), 1);
}

TEST(WriteReportWithoutPage, SaysWhatToDo) {
  if (can_write_reports()) {
    GTEST_SKIP() << "this build has the page";
  }
  const TemporaryFolder folder;
  EXPECT_THAT(why_no_reports(), HasSubstr("LIMBER_WITH_REPORT"));
  EXPECT_THROW(write_report(small_document(), folder.path() / "report.html"), std::runtime_error);
  EXPECT_TRUE(fs::is_empty(folder.path()));
}

}  // namespace
}  // namespace limber
