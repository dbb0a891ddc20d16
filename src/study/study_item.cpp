// SPDX-License-Identifier: MIT
#include "limber/study/study_item.hpp"

#include <cmath>
#include <new>
#include <stdexcept>
#include <string>

#include "bytes.hpp"
#include "figures_table.hpp"
#include "limber/core/divergence_error.hpp"
#include "limber/core/time.hpp"
#include "limber/diagnose/misled_since.hpp"
#include "limber/diagnose/run_summary.hpp"
#include "limber/simulate/simulator.hpp"
#include "run_observer.hpp"

namespace limber {
namespace {

RunFigures figures_of(const RunSummary& summary, const detail::MapError& map) {
  RunFigures out;
  out.position_rmse_m = summary.position_rmse_m;
  out.attitude_rmse_deg = summary.attitude_rmse_deg;
  out.position_final_m = summary.position_final_m;
  out.attitude_final_deg = summary.attitude_final_deg;
  out.position_max_m = summary.position_max_m;
  out.attitude_max_deg = summary.attitude_max_deg;
  if (map.points > 0) {
    out.landmark_rmse_m = std::sqrt(map.mean_squared);
  }
  out.ate_none_m = summary.ate_none_m;
  out.ate_se3_m = summary.ate_se3_m;
  out.ate_sim3_m = summary.ate_sim3_m;
  out.scale = summary.scale;
  out.anees = summary.anees;
  out.anees_position = summary.anees_position;
  out.anees_attitude = summary.anees_attitude;
  out.anees_scale = summary.anees_scale;
  out.share_within_95 = summary.share_within_95;
  out.frames_refused = static_cast<std::int64_t>(summary.frames_refused);
  out.nis = summary.nis;
  out.nis_dof = summary.nis_dof;
  out.path_length_m = summary.path_length_m;
  out.points_per_frame = summary.points_per_frame;
  out.frames = static_cast<std::int64_t>(summary.frames);
  out.points_refused = static_cast<std::int64_t>(summary.points_refused);
  out.ms_per_frame_mean = summary.ms_per_frame_mean;
  out.ms_per_frame_p50 = summary.ms_per_frame_p50;
  out.ms_per_frame_p99 = summary.ms_per_frame_p99;
  return out;
}

MethodResult compute_method(const Recording& recording, const Scenario& scenario, const RunOptions& options,
                            SharedStarts& starts, const std::function<bool()>& frame_done) {
  MethodResult out;
  out.run.run = options.run;
  detail::RunObserver observer(recording, scenario, options.start);
  const auto observe = [&](const ObservedFrame& frame) {
    observer.observe(frame);
    if (frame_done && !frame_done()) {
      throw ItemCancelled();
    }
  };
  try {
    RunRecord record =
        run_recording(recording, options, matched_frames(recording), {.observe = observe}, &starts);
    RunSummary summary = summarize(recording, options, record);
    add_misled(recording, options, record, summary);
    out.run.figures = figures_of(summary, observer.map_error());
    if (summary.inputs.lost_since_ns) {
      out.run.figures.lost_s = seconds_between(recording.frames.front().t_ns, *summary.inputs.lost_since_ns);
    }
    if (record.sensor_start) {
      out.run.figures.start_s = record.sensor_start->waited_s;
    }
  } catch (const DivergenceError& error) {
    out.run.diverged = observer.divergence(error.what());
  }  // whatever else goes wrong is no result: it ends the study
  out.series = observer.take_series();
  if (options.run == 0) {
    out.positions = observer.take_positions();
  }
  return out;
}

void put_method(detail::ByteWriter& out, const MethodResult& method) {
  out.put(method.run.run);
  out.put(method.run.diverged.has_value());
  const Divergence divergence = method.run.diverged.value_or(Divergence{});
  out.put(std::uint64_t{divergence.frame});
  out.put(divergence.t);
  out.put(divergence.reason);
  detail::visit_figures(method.run.figures, [&](const char*, const auto& figure) { out.put(figure); });
  out.put(std::uint64_t{method.series.size()});
  for (const RunSeries& series : method.series) {
    out.put(static_cast<std::uint8_t>(series.quantity));
    out.put(series.values);
  }
  out.put(std::uint64_t{method.positions.size()});
  for (const Eigen::Vector3d& p : method.positions) {
    out.put(p.x());
    out.put(p.y());
    out.put(p.z());
  }
}

MethodResult get_method(detail::ByteReader& in) {
  MethodResult out;
  in.get(out.run.run);
  const bool diverged = in.get<bool>();
  Divergence divergence;
  divergence.frame = in.get<std::uint64_t>();
  in.get(divergence.t);
  in.get(divergence.reason);
  if (diverged) {
    out.run.diverged = divergence;
  }
  detail::visit_figures(out.run.figures, [&](const char*, auto& figure) { in.get(figure); });
  for (auto n = in.get<std::uint64_t>(); n > 0; --n) {
    RunSeries series;
    series.quantity = static_cast<CurveQuantity>(in.get<std::uint8_t>());
    in.get(series.values);
    out.series.push_back(std::move(series));
  }
  for (auto n = in.get<std::uint64_t>(); n > 0; --n) {
    const auto x = in.get<double>(), y = in.get<double>(), z = in.get<double>();
    out.positions.emplace_back(x, y, z);
  }
  return out;
}

}  // namespace

ItemResult compute_item(const StudyPlan& plan, std::size_t study_case, std::uint64_t run,
                        const std::function<bool()>& frame_done) {
  const StudyCase& what = plan.cases.at(study_case);
  const Recording recording = simulate(what.scenario, plan.seed, run);
  ItemResult out{study_case, run, {}};
  SharedStarts starts;
  for (const MethodVariant& variant : what.methods) {
    try {
      out.methods.push_back(compute_method(recording, what.scenario,
                                           run_options(what.scenario, variant, what.start, plan.seed, run),
                                           starts, frame_done));
    } catch (const std::bad_alloc&) {
      throw;
    } catch (const std::exception& error) {
      throw std::runtime_error("case '" + what.scenario.name + "', run " + std::to_string(run) + ", method " +
                               to_string(variant) + ": " + error.what());
    }
  }
  return out;
}

std::string to_bytes(const ItemResult& result) {
  detail::ByteWriter out;
  out.put(std::uint64_t{result.study_case});
  out.put(result.run);
  out.put(std::uint64_t{result.methods.size()});
  for (const MethodResult& method : result.methods) {
    put_method(out, method);
  }
  return out.take();
}

ItemResult item_from_bytes(std::string_view bytes) {
  detail::ByteReader in(bytes);
  ItemResult out;
  out.study_case = in.get<std::uint64_t>();
  in.get(out.run);
  for (auto n = in.get<std::uint64_t>(); n > 0; --n) {
    out.methods.push_back(get_method(in));
  }
  in.expect_end();
  return out;
}

}  // namespace limber
