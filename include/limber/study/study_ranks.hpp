// SPDX-License-Identifier: MIT
#pragma once

namespace limber {

/// @brief The processes that share a study, started by mpirun or srun; or this one alone. Make it once,
/// early. MPI is not touched unless a launcher started several processes.
class StudyRanks {
 public:
  /// @throws std::runtime_error if a launcher started several, but limber was built without MPI
  StudyRanks();
  /// Rank 0: lets the others go.
  ~StudyRanks();
  StudyRanks(const StudyRanks&) = delete;
  StudyRanks& operator=(const StudyRanks&) = delete;

  /// Of this process; 0 owns the database. 0 without MPI.
  [[nodiscard]] int rank() const { return rank_; }
  /// How many processes take part; 1 without MPI.
  [[nodiscard]] int size() const { return size_; }

  /// @brief For ranks above 0: computes what rank 0 asks for, on that many threads (0: one), until it is let
  /// go. What goes wrong is reported to rank 0, which fails with it.
  void serve(int threads);

  /// For run_study: whether rank 0 has told the others of its plan, or that there is none.
  void told() { told_ = true; }

 private:
  int rank_ = 0, size_ = 1;
  bool told_ = false;
};

}  // namespace limber
