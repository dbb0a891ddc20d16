// SPDX-License-Identifier: MIT
// Rank 0 owns the database and hands out tasks one by one; the others compute. Only the main thread of a
// process speaks MPI.
#define OMPI_SKIP_MPICXX 1
#define MPICH_SKIP_MPICXX 1
#include <mpi.h>

#include <chrono>
#include <exception>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "bytes.hpp"
#include "launcher.hpp"
#include "limber/simulate/scenario_file.hpp"
#include "limber/study/study_ranks.hpp"
#include "rank_workforce.hpp"

namespace limber {
namespace {

using namespace std::chrono_literals;

// To a worker: a task (case, run), or that it may go. From a worker: a result, an error's text, farewell.
enum Tag : int { kTask = 1, kGo, kResult, kError, kFarewell };

/// Between two looks at the mail: MPI's own waiting would keep a core busy.
constexpr auto kNap = 500us;

using Clock = std::chrono::steady_clock;

void send(const std::string& bytes, int rank, Tag tag) {
  MPI_Send(bytes.data(), static_cast<int>(bytes.size()), MPI_BYTE, rank, tag, MPI_COMM_WORLD);
}

struct Message {
  int from = 0, tag = 0;
  std::string bytes;
};

/// The next message, if there is one.
std::optional<Message> receive() {
  int there = 0;
  MPI_Status status;
  MPI_Iprobe(MPI_ANY_SOURCE, MPI_ANY_TAG, MPI_COMM_WORLD, &there, &status);
  if (there == 0) {
    return std::nullopt;
  }
  int size = 0;
  MPI_Get_count(&status, MPI_BYTE, &size);
  Message message{status.MPI_SOURCE, status.MPI_TAG, std::string(static_cast<std::size_t>(size), '\0')};
  MPI_Recv(message.bytes.data(), size, MPI_BYTE, status.MPI_SOURCE, status.MPI_TAG, MPI_COMM_WORLD,
           MPI_STATUS_IGNORE);
  return message;
}

/// Rank 0's bytes, on every rank. The others sleep until they come, however long that is.
std::string broadcast(std::string bytes) {
  std::uint64_t size = bytes.size();
  MPI_Request request{};
  MPI_Ibcast(&size, 1, MPI_UINT64_T, 0, MPI_COMM_WORLD, &request);
  for (int done = 0; done == 0;) {
    MPI_Test(&request, &done, MPI_STATUS_IGNORE);
    if (done == 0) {
      std::this_thread::sleep_for(kNap);
    }
  }
  bytes.resize(size);
  MPI_Bcast(bytes.data(), static_cast<int>(size), MPI_BYTE, 0, MPI_COMM_WORLD);
  return bytes;
}

std::string plan_to_bytes(const StudyPlan& plan) {
  detail::ByteWriter out;
  out.put(plan.seed);
  out.put(std::uint64_t{plan.cases.size()});
  for (const StudyCase& study_case : plan.cases) {
    out.put(format_scenario(study_case.scenario));
    out.put(definition_of(study_case));
    out.put(study_case.runs);
    out.put(std::string(name_of(study_case.start)));
    out.put(std::uint64_t{study_case.methods.size()});
    for (const MethodVariant& method : study_case.methods) {
      out.put(to_string(method));
    }
  }
  return out.take();
}

StudyPlan plan_from_bytes(const std::string& bytes) {
  detail::ByteReader in(bytes);
  StudyPlan plan;
  in.get(plan.seed);
  std::string text, definition;
  for (auto cases = in.get<std::uint64_t>(); cases > 0; --cases) {
    StudyCase study_case;
    in.get(text);
    study_case.scenario = parse_scenario(text, "plan.yaml");
    in.get(definition);
    in.get(study_case.runs);
    in.get(text);
    study_case.start = start_mode_from_string(text);
    for (auto methods = in.get<std::uint64_t>(); methods > 0; --methods) {
      in.get(text);
      study_case.methods.push_back(method_variant_from_string(text));
    }
    if (definition_of(study_case) != definition) {
      throw std::runtime_error("case '" + study_case.scenario.name +
                               "': the trajectory file of this machine is not that of rank 0");
    }
    plan.cases.push_back(std::move(study_case));
  }
  return plan;
}

class RankWorkforce final : public detail::Workforce {
 public:
  RankWorkforce(const StudyPlan& plan, int threads, int ranks)
      : local_(detail::make_local_workforce(plan, threads)), idle_(static_cast<std::size_t>(ranks)) {
    broadcast(plan_to_bytes(plan));
    MPI_Gather(&threads, 1, MPI_INT, idle_.data(), 1, MPI_INT, 0, MPI_COMM_WORLD);
    for (const int idle : idle_) {
      capacity_ += static_cast<std::size_t>(idle);
    }
  }

  ~RankWorkforce() override {
    for (int rank = 1; rank < ranks(); ++rank) {
      send("", rank, kGo);
    }
    for (int here = ranks() - 1; here > 0;) {
      const auto message = receive();
      if (!message) {
        std::this_thread::sleep_for(kNap);
      } else if (message->tag == kFarewell) {
        --here;
      }
    }
  }

  [[nodiscard]] std::size_t capacity() const override { return capacity_; }

  void submit(const detail::Task& task) override {
    for (int rank = 0; rank < ranks(); ++rank) {
      int& idle = idle_[static_cast<std::size_t>(rank)];
      if (idle > 0) {
        --idle;
        hand_to(rank, task);
        return;
      }
    }
    throw std::logic_error("study: more tasks than workers");
  }

  [[nodiscard]] std::optional<detail::Finished> take(std::chrono::milliseconds patience) override {
    const auto deadline = Clock::now() + patience;
    do {
      if (auto finished = local_->take(0ms)) {
        ++idle_[0];
        return finished;
      }
      if (const auto message = receive()) {
        return finished_from(*message);
      }
      std::this_thread::sleep_for(kNap);
    } while (Clock::now() < deadline);
    return std::nullopt;
  }

  [[nodiscard]] std::uint64_t frames_done() const override {
    return local_->frames_done() + frames_elsewhere_;
  }

 private:
  [[nodiscard]] int ranks() const { return static_cast<int>(idle_.size()); }

  void hand_to(int rank, const detail::Task& task) {
    if (rank == 0) {
      local_->submit(task);
      return;
    }
    detail::ByteWriter out;
    out.put(std::uint64_t{task.study_case});
    out.put(task.run);
    send(out.take(), rank, kTask);
  }

  detail::Finished finished_from(const Message& message) {
    ++idle_[static_cast<std::size_t>(message.from)];
    if (message.tag == kError) {
      return {std::nullopt, std::make_exception_ptr(std::runtime_error(
                                "rank " + std::to_string(message.from) + ": " + message.bytes))};
    }
    detail::Finished finished{item_from_bytes(message.bytes), nullptr};
    for (const MethodResult& method : finished.result->methods) {
      frames_elsewhere_ += method.series.empty() ? 0 : method.series.front().values.size();
    }
    return finished;
  }

  std::unique_ptr<detail::Workforce> local_;
  std::vector<int> idle_;  // threads of each rank that have nothing to do
  std::size_t capacity_ = 0;
  std::uint64_t frames_elsewhere_ = 0;
};

std::string text_of(const std::exception_ptr& error) {
  try {
    std::rethrow_exception(error);
  } catch (const std::exception& e) {
    return e.what();
  } catch (...) {
    return "cancelled";
  }
}

/// Sends what the threads have finished.
bool report_finished(detail::Workforce& local) {
  const auto finished = local.take(0ms);
  if (!finished) {
    return false;
  }
  if (finished->result) {
    send(to_bytes(*finished->result), 0, kResult);
  } else {
    send(text_of(finished->error), 0, kError);
  }
  return true;
}

void work_for_rank_0(const StudyPlan& plan, int threads) {
  const auto local = detail::make_local_workforce(plan, threads);
  for (;;) {
    const bool reported = report_finished(*local);
    const auto message = receive();
    if (message && message->tag == kGo) {
      return;
    }
    if (message) {
      detail::ByteReader in(message->bytes);
      const auto study_case = in.get<std::uint64_t>(), run = in.get<std::uint64_t>();
      local->submit({study_case, run});
    } else if (!reported) {
      std::this_thread::sleep_for(kNap);
    }
  }
}

}  // namespace

StudyRanks::StudyRanks() {
  if (detail::launched_processes() > 1) {
    int provided = 0;
    MPI_Init_thread(nullptr, nullptr, MPI_THREAD_FUNNELED, &provided);
    MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
    MPI_Comm_size(MPI_COMM_WORLD, &size_);
  }
}

StudyRanks::~StudyRanks() {
  int started = 0;
  MPI_Initialized(&started);
  // A worker that fails leaves without farewell, which the launcher notices: MPI_Finalize would wait for rank
  // 0.
  if (started != 0 && (rank_ == 0 || std::uncaught_exceptions() == 0)) {
    if (rank_ == 0 && !told_) {
      broadcast("");
    }
    MPI_Finalize();
  }
}

void StudyRanks::serve(int threads) {
  threads = threads > 0 ? threads : 1;
  const std::string bytes = broadcast("");
  if (bytes.empty()) {
    return;
  }
  const StudyPlan plan = plan_from_bytes(bytes);
  MPI_Gather(&threads, 1, MPI_INT, nullptr, 0, MPI_INT, 0, MPI_COMM_WORLD);
  work_for_rank_0(plan, threads);
  send("", 0, kFarewell);
}

namespace detail {

std::unique_ptr<Workforce> make_rank_workforce(StudyRanks& ranks, const StudyPlan& plan, int threads) {
  ranks.told();
  return std::make_unique<RankWorkforce>(plan, threads, ranks.size());
}

}  // namespace detail
}  // namespace limber
