// SPDX-License-Identifier: MIT
#include "version.hpp"

#include "version_of_build.hpp"  // made by cmake/write_version.cmake

namespace limber::app {

std::string version_text() {
  return "limber " LIMBER_VERSION "\ncommit " LIMBER_COMMIT ", " LIMBER_BUILD_TYPE ", for " LIMBER_PROCESSOR
         "\nwith " LIMBER_PARTS;
}

}  // namespace limber::app
