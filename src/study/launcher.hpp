// SPDX-License-Identifier: MIT
#pragma once

namespace limber::detail {

/// Processes that mpirun (OpenMPI, MPICH) or srun (PMIx) started together with this one, as the environment
/// says; 1 if none did.
[[nodiscard]] int launched_processes();

}  // namespace limber::detail
