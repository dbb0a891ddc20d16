// SPDX-License-Identifier: MIT
#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "source_folder.hpp"

/// Real recordings, which are not part of the repository: in the folder LIMBER_DATA, else beside the
/// repository.
namespace limber::testing {

inline std::filesystem::path real_data_folder() {
  const char* folder = std::getenv("LIMBER_DATA");
  return folder != nullptr && *folder != '\0' ? std::filesystem::path(folder)
                                              : source_folder() / "../shared/data";
}

}  // namespace limber::testing

/// Declares `folder`, the real data called `name`, or skips the test where it is not there.
#define LIMBER_NEED_DATA(folder, name)                                                                      \
  const std::filesystem::path folder = ::limber::testing::real_data_folder() / (name);                      \
  if (!std::filesystem::exists(folder)) {                                                                   \
    GTEST_SKIP() << "no real data at " << folder << "; the variable LIMBER_DATA names the folder it is in"; \
  }
