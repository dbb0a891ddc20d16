// SPDX-License-Identifier: MIT
#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <regex>
#include <sstream>

#include "cli/child_process.hpp"
#include "cli/small_log.hpp"
#include "limber/datasets/trajectory_files.hpp"

namespace limber {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::Each;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::IsSupersetOf;
using ::testing::MatchesRegex;
using ::testing::Not;
using ::testing::StartsWith;
using Json = nlohmann::json;
using testing::expect_refused;
using testing::files_below;
using testing::ProgramResult;
using testing::read_text;
using testing::write_text;

using RunCommand = testing::SmallLog;

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) {
    lines.push_back(line);
  }
  return lines;
}

Json summary_in(const fs::path& folder) { return Json::parse(read_text(folder / "summary.json")); }

/// All that a run wrote, without what a clock says.
std::string content_without_times(const fs::path& folder) {
  std::string content;
  for (const char* const name :
       {"trajectory.tum", "trajectory.csv", "landmarks.ply", "health.csv", "refusals.csv"}) {
    content += read_text(folder / name);
  }
  // The last two columns of frames.csv are times.
  content += std::regex_replace(read_text(folder / "frames.csv"), std::regex(",[0-9.]+,[0-9.]+\n"), "\n");
  Json summary = summary_in(folder);
  for (const char* const key : {"ms_per_frame", "start_ms", "realtime_factor", "peak_rss_mb"}) {
    summary.erase(key);
  }
  return content + summary.dump();
}

TEST_F(RunCommand, WritesItsFilesWellFormed) {
  ASSERT_EQ(run().exit_code, 0);
  EXPECT_THAT(files_below(out()),
              IsSupersetOf({"trajectory.tum", "trajectory.csv", "truth.tum", "landmarks.ply", "frames.csv",
                            "truth.csv", "health.csv", "refusals.csv", "summary.json"}));
  EXPECT_LE(files_below(out()).size(), 10u);  // and report.html, if this build makes pages
  const auto rows = read_trajectory_csv(out() / "trajectory.csv");
  const auto poses = read_tum(out() / "trajectory.tum");
  ASSERT_EQ(rows.size(), 41u);
  ASSERT_EQ(poses.size(), 41u);
  for (std::size_t k = 0; k < rows.size(); ++k) {
    EXPECT_EQ(rows[k].t_ns, static_cast<std::int64_t>(k) * 50'000'000);
    EXPECT_EQ(poses[k].t_ns, rows[k].t_ns);
    EXPECT_EQ(poses[k].T_world_body.p, rows[k].T_world_body.p);
    EXPECT_TRUE(rows[k].v_world_body && rows[k].bias_gyro && rows[k].bias_accel && rows[k].covariance);
    EXPECT_TRUE(rows[k].sigma_v && rows[k].sigma_bias_gyro && rows[k].sigma_bias_accel);
  }
  const auto ply = lines_of(read_text(out() / "landmarks.ply"));
  ASSERT_GT(ply.size(), 40u);
  EXPECT_EQ(ply[3], "element vertex " + std::to_string(ply.size() - 9));
  EXPECT_EQ(lines_of(read_text(out() / "frames.csv")).size(), 42u);
  const Json summary = summary_in(out());
  EXPECT_EQ(summary["method"], "lcekf");
  EXPECT_EQ(summary["dataset"], "log");
  EXPECT_EQ(summary["frames"], 41);
  // Of two seconds, one of which the start takes, how far is luck (0.1 to 1.6 m on other draws). That it is
  // known is not, nor where the truth is the start.
  EXPECT_LT(summary["anees"], 3.0);
  ASSERT_EQ(run_into(folder() / "from_truth", {"--init", "groundtruth"}).exit_code, 0);
  EXPECT_LT(summary_in(folder() / "from_truth")["ate_m"]["se3"], 0.2);
  EXPECT_NE(summary["health"]["verdict"], "ok");  // case (ii), of which two seconds show little
}

TEST_F(RunCommand, PrintsTheResultToStdoutAndNotesToStderrWithoutAnyAnimation) {
  const ProgramResult result = run();
  EXPECT_THAT(result.out, StartsWith("lcekf on log\n  answer          "));
  EXPECT_THAT(result.out, HasSubstr("\n  what to do      "));
  EXPECT_THAT(result.out, HasSubstr("\n  frames          41 in 2.0 s"));
  EXPECT_THAT(result.out, HasSubstr("results in      " + out().string()));
  EXPECT_THAT(lines_of(result.err), Each(MatchesRegex("limber: [a-zA-Z].*")));
  EXPECT_THAT(result.err, HasSubstr("constraints full: the scale comes from the IMU"));
  for (const std::string& text : {result.out, result.err}) {
    EXPECT_THAT(text, AllOf(Not(HasSubstr("\r")), Not(HasSubstr("\x1b"))));
  }
}

TEST_F(RunCommand, GivesTheSameBitsTwiceAndOthersForAnotherSeedOrRun) {
  const std::vector<std::string> start = {"--init", "groundtruth", "--seed", "5", "--run", "2"};
  for (const char* const name : {"a", "b"}) {
    ASSERT_EQ(run_into(folder() / name, start).exit_code, 0);
  }
  const std::string content = content_without_times(folder() / "a");
  EXPECT_EQ(content, content_without_times(folder() / "b"));
  ASSERT_EQ(run_into(folder() / "c", {"--init", "groundtruth", "--seed", "6", "--run", "2"}).exit_code, 0);
  ASSERT_EQ(run_into(folder() / "d", {"--init", "groundtruth", "--seed", "5", "--run", "3"}).exit_code, 0);
  EXPECT_NE(content, content_without_times(folder() / "c"));
  EXPECT_NE(content, content_without_times(folder() / "d"));
}

TEST_F(RunCommand, KnowsEveryMethod) {
  for (const std::string method : {"ekf", "ekf-full", "lcekf", "soft", "consider", "mono-left", "oracle"}) {
    const ProgramResult result = run_again({"--method", method, "--init", "groundtruth"});
    EXPECT_EQ(result.exit_code, 0) << method << result.err;
    EXPECT_EQ(summary_in(out())["method"], method);
  }
}

TEST_F(RunCommand, AssumesTheErrorItIsTold) {
  const auto error_of = [this](const std::string& method, const std::string& error) {
    const fs::path folder = this->folder() / (method + error);
    EXPECT_EQ(
        run_into(folder, {"--method", method, "--assume-error", error, "--init", "groundtruth", "--force"})
            .exit_code,
        0);
    return summary_in(folder)["position_rmse_m"].get<double>();
  };
  const std::string none = "0,0,0,0,0,0", wrong = "0,0.5,0,20%,0,0";
  EXPECT_GT(error_of("ekf", wrong), 2.0 * error_of("ekf", none));
  EXPECT_LT(error_of("lcekf", wrong), 0.5 * error_of("ekf", wrong));
  const auto theta = summary_in(folder() / ("ekf" + wrong))["theta"];  // 2 m, and 20 % of it shorter
  EXPECT_NEAR(theta[1].get<double>(), 0.5 * M_PI / 180.0, 1e-12);
  EXPECT_NEAR(theta[3].get<double>(), -1.6, 1e-12);
}

TEST_F(RunCommand, EstimatesSoftensAndConstrainsOtherParameters) {
  const auto rmse_with = [this](const std::vector<std::string>& options) {
    std::vector<std::string> arguments = {"--assume-error", "fu1=3%", "--init", "groundtruth"};
    arguments.insert(arguments.end(), options.begin(), options.end());
    const ProgramResult result = run_again(arguments);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_EQ(result.out.find("estimated       fu1     -") != std::string::npos,
              !summary_in(out())["estimated"].is_null())
        << result.out;
    return summary_in(out())["position_rmse_m"].get<double>();
  };
  const double trusting = rmse_with({"--method", "lcekf"});  // all but the focal length
  EXPECT_TRUE(summary_in(out())["estimated"].is_null());
  EXPECT_LT(rmse_with({"--method", "lcekf", "--constraints", "full,fu1"}), 0.7 * trusting);
  EXPECT_LT(rmse_with({"--method", "lcekf", "--soften", "fu1=9"}), 0.7 * trusting);
  EXPECT_LT(rmse_with({"--method", "lcekf", "--estimate", "fu1=9"}), 0.7 * trusting);
  const Json found = summary_in(out())["estimated"]["fu1"];
  EXPECT_NEAR(found["error"].get<double>(), -9.0, 4.0 * found["sigma"].get<double>());
  EXPECT_LT(found["sigma"].get<double>(), 1.0);
  EXPECT_EQ(lines_of(read_text(out() / "calibration.csv")).size(), 42U);
}

TEST_F(RunCommand, ObeysItsOtherOptions) {
  ASSERT_EQ(run_into(folder() / "sensors").exit_code, 0);
  ASSERT_EQ(run_into(folder() / "default", {"--init", "groundtruth"}).exit_code, 0);
  const std::string usual = content_without_times(folder() / "default");
  EXPECT_NE(content_without_times(folder() / "sensors"), usual);
  ASSERT_EQ(run_into(folder() / "loud", {"--init", "GroundTruth", "--gate", "ON"}).exit_code, 0);
  EXPECT_EQ(content_without_times(folder() / "loud"), usual);
  for (const std::vector<std::string>& options : {std::vector<std::string>{"--constraints", "rotation"},
                                                  {"--constraints", "ax,tx"},
                                                  {"--sigma-px", "0.7"},
                                                  {"--landmarks", "cartesian"},
                                                  {"--max-landmarks", "3"}}) {
    std::vector<std::string> arguments = options;
    arguments.insert(arguments.end(), {"--init", "groundtruth"});
    const ProgramResult result = run_again(arguments);
    ASSERT_EQ(result.exit_code, 0) << result.err;
    EXPECT_NE(content_without_times(out()), usual) << options[0] << " " << options[1];
  }
  // Two of the pixels are wrong by 60 px: the gate refuses those points, without it nobody does.
  std::string tracks = read_text(mav0() / "tracks0/data.csv");
  const std::size_t frame = tracks.find("\n1900000000,");
  write_text(mav0() / "tracks0/data.csv",
             tracks.substr(0, frame) +
                 "\n1900000000,90001,100,100,160,160\n1900000000,90002,300,300,200,340" +
                 tracks.substr(frame));
  ASSERT_EQ(run_into(folder() / "on", {"--gate", "on", "--init", "groundtruth"}).exit_code, 0);
  ASSERT_EQ(run_into(folder() / "off", {"--gate", "off", "--init", "groundtruth"}).exit_code, 0);
  EXPECT_GT(summary_in(folder() / "on")["points_refused"], summary_in(folder() / "off")["points_refused"]);
}

TEST_F(RunCommand, RefusesOptionsThatMakeNoSenseAsWrongUsage) {
  struct BadOption {
    std::vector<std::string> arguments;
    std::string words;
  };
  for (const BadOption& bad : {
           BadOption{{"--method", "ekff"},
                     "unknown method 'ekff' (did you mean ekf?), expected one of ekf, ekf-full, lcekf"},
           {{"--constraints", "bx"}, "unknown constraint set 'bx', expected full, none, rotation"},
           {{"--constraints", ""}, "unknown constraint set ''"},
           {{"--method", "ekf", "--constraints", "full"}, "lcekf alone has constraints, not ekf"},
           {{"--assume-error", "1,2,3"}, "expected six numbers ax,ay,az,tx,ty,tz"},
           {{"--assume-error", "0,0,0,nan,0,0"}, "found '0,0,0,nan,0,0'"},
           {{"--assume-error", "200,0,0,0,0,0"}, "degrees within ±180"},
           {{"--assume-error", "5%,0,0,0,0,0"}, "found '5%,0,0,0,0,0'"},
           {{"--assume-error", "dt1=soon"}, "found 'dt1=soon'"},
           {{"--estimate", "dt2"},
            "unknown parameter 'dt2' in 'dt2' (did you mean dt0?), expected a list of ax, ay"},
           {{"--soften", "dt1=-1"}, "expected NAME or NAME=SIGMA with a positive number (s)"},
           {{"--sigma-px", "0"}, "--sigma-px: expected a positive number, found '0'"},
           {{"--sigma-px", "nan"}, "--sigma-px: expected a positive number, found 'nan'"},
           {{"--seed", "-1"}, "--seed: expected a whole number from 0"},
           {{"--seed", "99999999999999999999"}, "--seed: expected a whole number"},
           {{"--run", "1.5"}, "--run: expected a whole number"},
           {{"--max-landmarks", "0"}, "--max-landmarks: expected a whole number from 1 to 100000, found '0'"},
           {{"--init", "truth"}, "auto"},
           {{"--init", "goundtruth"}, "(did you mean groundtruth?)"},
           {{"--constraints", "full,dt11"}, "(did you mean dt1?)"},
           {{"--landmarks", "spherical"}, "inverse-depth"},
           {{"--gate", "maybe"}, "on"},
           {{"--method", "ekf", "--method", "lcekf"}, "--method is given more than once"},
           {{"--method"}, "--method needs a value"},
           {{"--metod", "ekf"}, "unknown option --metod"},
           {{"more"}, "unexpected argument: more"},
       }) {
    const ProgramResult result = run(bad.arguments);
    expect_refused(result, 2, bad.words);
    EXPECT_THAT(result.err, HasSubstr("try: limber run --help"));
    EXPECT_FALSE(fs::exists(out()));
  }
  expect_refused(testing::run_limber({"run", log().string()}), 2, "--out is required");
  expect_refused(testing::run_limber({"run", log().string(), "--out", ""}), 2, "--out: expected a name");
}

TEST_F(RunCommand, RefusesWhatTheRecordingCannotGive) {
  fs::remove_all(mav0() / "calibration_truth0");
  fs::remove_all(mav0() / "state_groundtruth_estimate0");
  expect_refused(run({"--init", "groundtruth"}), 1, "log has no ground truth; use --init auto");
  expect_refused(run({"--method", "oracle"}), 1, "log does not say what the true calibration is");
  expect_refused(run({"--assume-error", "0,0,0,100%,0,0"}), 1, "leaves cam1 on its side of cam0");
  expect_refused(run({"--estimate", "dt1", "--constraints", "full,dt1"}), 1,
                 "dt1 cannot be constrained and estimated at once");
  expect_refused(run({"--sigma-px", "1e-300"}), 1, "pixel noise: expected 1e-06 to 1000 px");
  EXPECT_FALSE(fs::exists(out()));
}

TEST_F(RunCommand, RunsOnOdometryAndOnVisionAloneAndSaysWhatItAssumes) {
  fs::remove_all(mav0() / "imu0");
  EXPECT_THAT(run().err, HasSubstr("constraints full: the scale comes from the odometry"));
  fs::remove_all(mav0() / "odometry0");
  const ProgramResult result = run_again();
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.err, HasSubstr("neither IMU nor odometry: constant-velocity model"));
  EXPECT_THAT(result.err, HasSubstr("constraints rotation+direction"));
  fs::remove_all(mav0() / "state_groundtruth_estimate0");
  EXPECT_THAT(run_again().out, HasSubstr("ATE             SE(3) unknown, Sim(3) unknown, scale unknown"));
}

TEST_F(RunCommand, DoesNotMindLineEndsOfWindowsOrAByteOrderMark) {
  ASSERT_EQ(run_into(folder() / "plain").exit_code, 0);
  for (const std::string& name : files_below(mav0())) {
    if (fs::is_regular_file(mav0() / name)) {
      write_text(mav0() / name,
                 "\xef\xbb\xbf" + std::regex_replace(read_text(mav0() / name), std::regex("\n"), "\r\n"));
    }
  }
  ASSERT_EQ(run_into(folder() / "windows").exit_code, 0);
  EXPECT_EQ(content_without_times(folder() / "plain"), content_without_times(folder() / "windows"));
}

TEST_F(RunCommand, TakesALogOfOneFrameOrOnePoint) {
  const auto lines = lines_of(read_text(mav0() / "tracks0/data.csv"));
  std::string one_frame;
  for (const std::string& line : lines) {
    one_frame += line.starts_with('#') || line.starts_with("0,") ? line + "\n" : "";
  }
  write_text(mav0() / "tracks0/data.csv", one_frame);
  EXPECT_THAT(run().out, HasSubstr("frames          1 in 0.0 s"));
  write_text(mav0() / "tracks0/data.csv", lines[0] + "\n" + lines[1] + "\n");
  EXPECT_THAT(run_again().out, HasSubstr("frames          1 in 0.0 s"));
}

TEST_F(RunCommand, FailsBeforeTheWorkWhereTheOutputCannotBeWritten) {
  const fs::path file = write_text(folder() / "file", "mine");
  for (const fs::path& place : {file, file / "below", fs::path("/proc/limber/run"), fs::path("/dev/null")}) {
    expect_refused(run_into(place), 1, place.string() + ": expected a folder that can be made and written");
  }
  EXPECT_EQ(read_text(file), "mine");
  EXPECT_THAT(files_below(folder()), Not(::testing::Contains(HasSubstr("partial"))));
}

TEST_F(RunCommand, LeavesNothingAndOlderResultsAloneWhenItFails) {
  ASSERT_EQ(run().exit_code, 0);
  const std::string before = content_without_times(out());
  const auto files = files_below(out());
  const testing::SmallDisk disk;
  expect_refused(run_again({"--method", "ekf"}), 1, "room to write the file");
  expect_refused(run_into(folder() / "new" / "nested"), 1, "room to write the file");
  EXPECT_EQ(content_without_times(out()), before);
  EXPECT_EQ(files_below(out()), files);
  EXPECT_FALSE(fs::exists(folder() / "new"));
}

/// A run that takes seconds.
class LongRun : public ::testing::Test {
 protected:
  LongRun() {
    Scenario scenario = testing::short_scenario();
    scenario.duration = 60.0;
    write_track_log(simulate(scenario, 1), folder_.path() / "log");
  }
  [[nodiscard]] fs::path out() const { return folder_.path() / "new" / "out"; }
  [[nodiscard]] static bool claimed(const testing::ProgramResult& result) {
    return result.err.find("claimed by a limber that runs") != std::string::npos;
  }
  [[nodiscard]] std::vector<std::string> arguments() const {
    return {"run", (folder_.path() / "log").string(), "--out", out().string(), "--init", "groundtruth"};
  }

 private:
  const testing::TemporaryFolder folder_;
};

TEST_F(LongRun, LeavesNothingBehindWhenItIsKilled) {
  ASSERT_TRUE(testing::start_and_kill_limber(arguments(), SIGKILL, 1000));
  EXPECT_FALSE(fs::exists(out().parent_path()));
}

TEST_F(LongRun, HasItsFolderForItselfAndHandsItOverHoweverItEnds) {
  for (const int end : {SIGKILL, SIGINT}) {
    std::optional<testing::ChildProcess> first;
    testing::ProgramResult second;
    // Asked before the first one has begun, the second claims the place, and the first may be refused.
    for (useconds_t delay = 200'000; !claimed(second) && delay < 10'000'000; delay *= 2) {
      first.emplace(arguments());
      usleep(delay);
      second = testing::run_limber({"run", "no-recording", "--out", (out() / "").string(), "--force"});
    }
    testing::expect_refused(second, 1,
                            out().string() + "/: expected a place that no other limber is working for");
    EXPECT_THAT(
        testing::run_limber({"run", "no-recording", "--methods", "ekf,lcekf", "--out", out().string()}).err,
        HasSubstr("claimed by a limber that runs"));
    EXPECT_THAT(testing::run_limber({"convert", "no-recording", "--out", out().string()}).err,
                HasSubstr("claimed by a limber that runs"));
    first->signal(end);
    (void)first->wait();
    EXPECT_THAT(testing::run_limber({"run", "no-recording", "--out", out().string(), "--force"}).err,
                HasSubstr("no-recording: expected the folder of a recording"));
  }
}

TEST_F(LongRun, KeepsWhatIsDoneOnCtrlCAndSaysThatItIsPartial) {
  // How long reading takes differs: too early nothing is done yet, too late all is.
  for (useconds_t delay = 500'000; !fs::exists(out() / "summary.json") && delay < 10'000'000; delay *= 2) {
    testing::ChildProcess run(arguments());
    usleep(delay);
    run.signal(SIGINT);
    EXPECT_EQ(run.wait(), 1);
    EXPECT_THAT(run.err(), ::testing::AnyOf(HasSubstr("these are partial results"),
                                            HasSubstr("stopped before the first frame: nothing is written")));
  }
  const Json summary = Json::parse(read_text(out() / "summary.json"));
  EXPECT_EQ(summary["complete"], false);
  EXPECT_LT(summary["frames"], summary["frames_of_recording"]);
  EXPECT_EQ(lines_of(read_text(out() / "frames.csv")).size(), summary["frames"].get<std::size_t>() + 1);
}

}  // namespace
}  // namespace limber
