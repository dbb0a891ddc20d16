// SPDX-License-Identifier: MIT
#include "launcher.hpp"

#include <algorithm>
#include <array>
#include <cstdlib>

namespace limber::detail {

int launched_processes() {
  constexpr std::array kVariables = {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE"};
  for (const char* const variable : kVariables) {
    if (const char* const value = std::getenv(variable)) {
      return std::max(1, std::atoi(value));
    }
  }
  // srun with PMIx.
  const char* const tasks = std::getenv("SLURM_STEP_NUM_TASKS");
  return std::getenv("PMIX_RANK") != nullptr && tasks != nullptr ? std::max(1, std::atoi(tasks)) : 1;
}

}  // namespace limber::detail
