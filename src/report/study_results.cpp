// SPDX-License-Identifier: MIT
#include "limber/report/study_results.hpp"

namespace limber {
namespace {

StudyMethodResults load_method(const StudyDatabase& database, std::size_t study_case, std::size_t method,
                               const MethodSummary& summary) {
  StudyMethodResults out;
  out.variant = database.info().cases[study_case].methods[method];
  out.summary = summary;
  out.runs = database.runs(study_case, method);
  for (std::size_t k = 0; k < kCurveQuantities; ++k) {
    const auto quantity = static_cast<CurveQuantity>(k);
    if (auto curve = database.curve(study_case, method, quantity)) {
      out.curves.emplace(quantity, std::move(*curve));
    }
  }
  return out;
}

}  // namespace

StudyResults load_study(const std::filesystem::path& path) {
  const StudyDatabase database(path);
  const StudyInfo& info = database.info();
  StudyResults out{info.program_version, info.seed, {}};
  for (std::size_t c = 0; c < info.cases.size(); ++c) {
    StudyCaseResults& results = out.cases.emplace_back();
    results.info = info.cases[c];
    results.example = database.example(c);
    const std::vector<MethodSummary> summaries = summarize_case(database, c);
    for (std::size_t m = 0; m < summaries.size(); ++m) {
      results.methods.push_back(load_method(database, c, m, summaries[m]));
    }
  }
  return out;
}

}  // namespace limber
