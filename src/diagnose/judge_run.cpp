// SPDX-License-Identifier: MIT
#include "limber/diagnose/judge_run.hpp"

#include "limber/diagnose/misled_since.hpp"
#include "limber/diagnose/overruled_since.hpp"
#include "limber/diagnose/trusted_rig.hpp"

namespace limber {

RunSummary judge_run(const Recording& recording, const RunOptions& options,
                     const std::optional<ReadoutTime>& readout, RunRecord& record) {
  RunSummary out = summarize(recording, options, record);
  add_misled(recording, options, record, out);
  add_scale_check(recording, options, record, out);
  add_readout(readout, recording.calibration, record, out);
  add_trusted_rig(options, record, out);
  add_overruled(record, out);  // last: the run is lost, and what was found out of the rig stays
  return out;
}

}  // namespace limber
