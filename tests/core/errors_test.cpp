// SPDX-License-Identifier: MIT
#include "limber/core/errors.hpp"

#include <gtest/gtest.h>

#include <string>

namespace limber {
namespace {

TEST(DataError, NamesFileLineAndBothSidesOfTheComplaint) {
  const DataError error("mav0/imu0/data.csv", 17, "7 columns", "3");
  EXPECT_EQ(std::string(error.what()), "mav0/imu0/data.csv:17: expected 7 columns, found 3");
  EXPECT_EQ(error.file(), "mav0/imu0/data.csv");
  EXPECT_EQ(error.line(), 17U);
}

TEST(DataError, LeavesTheLineOutWhenTheWholeFileIsMeant) {
  const DataError error("mav0/cam0/sensor.yaml", 0, "a file", "nothing");
  EXPECT_EQ(std::string(error.what()), "mav0/cam0/sensor.yaml: expected a file, found nothing");
  EXPECT_EQ(error.line(), 0U);
}

TEST(DataError, SaysBothSidesAloneOfATextThatIsNoFile) {
  EXPECT_EQ(DataError("ay:1: expected=2", 1, "a key", "'ay'").without_place(), "expected a key, found 'ay'");
  EXPECT_EQ(DataError("ay", 0, "a key", "'ay'").without_place(), "expected a key, found 'ay'");
}

TEST(DataError, IsCaughtAsARuntimeError) {
  EXPECT_THROW(throw DataError("a", 1, "b", "c"), std::runtime_error);
}

}  // namespace
}  // namespace limber
