// SPDX-License-Identifier: MIT
// A Monte Carlo study: which method stands this rig, and which knows how wrong it is (ANEES 1)?
#include <limber/study/run_study.hpp>
#include <limber/study/study_database.hpp>
#include <limber/study/study_table.hpp>

#include <cstdlib>
#include <filesystem>
#include <iostream>

int main() {
  limber::Scenario scenario;  // or limber::read_scenario("scenarios/paper_ii.yaml")
  scenario.duration = 4.0;
  scenario.decalibration.push_back({limber::paper_decalibration(), limber::ConstantShape{}});

  limber::StudyPlan plan;
  plan.cases.push_back({scenario, limber::method_variants_from_string("ekf,lcekf"), 3});
  const std::filesystem::path database = "example_study.sqlite";
  std::filesystem::remove(database);  // else it goes on with what is there
  limber::run_study(plan, database);

  const limber::StudyDatabase results(database);
  std::cout << limber::format_study_table(results);
  return results.info().cases[0].finished == 3 ? EXIT_SUCCESS : EXIT_FAILURE;
}
